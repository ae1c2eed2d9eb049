//! Letters of other alphabets in plain ASCII, for formats and fonts that have nothing else.

/// What stands for a character in 7-bit ASCII; `None` where nothing does.
pub(super) fn ascii(c: char) -> Option<&'static str> {
    const SINGLE: &[(&str, &str)] = &[
        ("ÀÁÂÃÅĀĂĄ", "A"),
        ("àáâãåāăą", "a"),
        ("ÇĆĈĊČ", "C"),
        ("çćĉċč", "c"),
        ("ÐĎĐ", "D"),
        ("ðďđ", "d"),
        ("ÈÉÊËĒĔĖĘĚ", "E"),
        ("èéêëēĕėęě", "e"),
        ("ĜĞĠĢ", "G"),
        ("ĝğġģ", "g"),
        ("ĤĦ", "H"),
        ("ĥħ", "h"),
        ("ÌÍÎÏĨĪĬĮİ", "I"),
        ("ìíîïĩīĭįı", "i"),
        ("Ĵ", "J"),
        ("ĵ", "j"),
        ("Ķ", "K"),
        ("ķĸ", "k"),
        ("ĹĻĽĿŁ", "L"),
        ("ĺļľŀł", "l"),
        ("ÑŃŅŇŊ", "N"),
        ("ñńņňŉŋ", "n"),
        ("ÒÓÔÕŌŎ", "O"),
        ("òóôõōŏº", "o"),
        ("ŔŖŘ", "R"),
        ("ŕŗř", "r"),
        ("ŚŜŞŠȘ", "S"),
        ("śŝşšșſ", "s"),
        ("ŢŤŦȚ", "T"),
        ("ţťŧț", "t"),
        ("ÙÚÛŨŪŬŮŲ", "U"),
        ("ùúûũūŭůų", "u"),
        ("Ŵ", "W"),
        ("ŵ", "w"),
        ("ÝŶŸ", "Y"),
        ("ýÿŷ", "y"),
        ("ŹŻŽ", "Z"),
        ("źżž", "z"),
        ("Ä", "Ae"),
        ("ä", "ae"),
        ("ÖŐ", "Oe"),
        ("öő", "oe"),
        ("ÜŰ", "Ue"),
        ("üű", "ue"),
        ("Æ", "AE"),
        ("æ", "ae"),
        ("Ø", "Oe"),
        ("ø", "oe"),
        ("Œ", "OE"),
        ("œ", "oe"),
        ("ß", "ss"),
        ("ẞ", "SS"),
        ("Þ", "Th"),
        ("þ", "th"),
        ("Ĳ", "IJ"),
        ("ĳ", "ij"),
        ("×", "x"),
        ("÷", "/"),
        ("°", "deg"),
        ("±", "+-"),
        ("·•", "."),
        ("–—‐‑‒−", "-"),
        ("‘’‚′´", "'"),
        ("“”„«»″", "\""),
        ("…", "..."),
        ("½", "1/2"),
        ("¼", "1/4"),
        ("¾", "3/4"),
        ("²", "2"),
        ("³", "3"),
        ("¹", "1"),
        ("ª", "a"),
        ("µμ", "u"),
        ("€", "EUR"),
        ("£", "GBP"),
        ("¥", "JPY"),
        ("©", "(c)"),
        ("®", "(R)"),
        ("™", "(TM)"),
        ("→", "->"),
        ("←", "<-"),
        ("≤", "<="),
        ("≥", ">="),
        ("≈", "~"),
        ("⌀∅", "dia"),
        ("§", "Par."),
        ("\u{a0}\u{2009}\u{202f}\t", " "),
    ];
    let row = SINGLE.iter().find(|(letters, _)| letters.contains(c));
    row.map(|&(_, letters)| letters)
}

/// Text in printable ASCII: other letters by their like, what has none as `_`, control characters left out.
pub(super) fn to_ascii(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            ' '..='~' => out.push(c),
            c => match ascii(c) {
                Some(letters) => out += letters,
                None if c.is_control() => {}
                None => out.push('_'),
            },
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_letters_become_ascii() {
        let text = to_ascii("Größe ½ Ærø × 30° Łódź \u{7}模");
        assert_eq!(text, "Groesse 1/2 AEroe x 30deg Lodz _");
        // Every letter of Latin-1 and Latin Extended-A has its like.
        for c in ('\u{c0}'..='\u{17f}').filter(|c| c.is_alphabetic()) {
            let like = ascii(c).unwrap_or_else(|| panic!("{c}"));
            assert!(!like.is_empty() && like.bytes().all(|b| (32..127).contains(&b)));
        }
    }
}
