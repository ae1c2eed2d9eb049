//! Names that every reader takes and tells apart.

use crate::pattern::transliterate::to_ascii;

/// Longest name of release 12.
const LONGEST: usize = 31;

/// Names of blocks: capitals, digits, `_`, `-`, `$`; at most 31 characters; no two alike.
pub(super) fn unique(names: &[String]) -> Vec<String> {
    let mut taken: Vec<String> = Vec::new();
    for name in names {
        let plain: String = to_ascii(name)
            .to_ascii_uppercase()
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() || matches!(c, '-' | '$') { c } else { '_' })
            .take(LONGEST)
            .collect();
        let plain = if plain.is_empty() { "PIECE".to_owned() } else { plain };
        let mut candidate = plain.clone();
        let mut number = 1;
        while taken.contains(&candidate) {
            number += 1;
            let end = format!("_{number}");
            candidate = plain[..plain.len().min(LONGEST - end.len())].to_owned() + &end;
        }
        taken.push(candidate);
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_short_plain_and_no_two_alike() {
        let given =
            ["A", "a", "Größe ½", "", "x<y>", &"long ".repeat(20), &"Long ".repeat(20), "A"];
        let names = unique(&given.map(str::to_owned));
        assert_eq!(&names[..5], ["A", "A_2", "GROESSE_1_2", "PIECE", "X_Y_"]);
        assert_eq!(names[6], "LONG_LONG_LONG_LONG_LONG_LONG_2"[..31]);
        assert_eq!(names[7], "A_3");
        assert!(names.iter().all(|n| n.len() <= 31));
    }
}
