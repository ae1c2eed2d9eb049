//! The words of a text, line by line: what OBJ, OFF and the text forms of PLY and STL have in common.
//!
//! Guaranteed: linear time and no copies, whatever the bytes are; LF, CRLF and CR all end lines. Not guaranteed: that a
//! word is UTF-8.

/// A place in a text.
#[derive(Clone, Copy)]
pub(super) struct Words<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
    /// The line that `at` is on, counted from 1.
    pub(super) line: u32,
}

impl<'a> Words<'a> {
    /// The beginning of a text.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, line: 1 }
    }

    /// Whether nothing is left.
    pub(super) fn is_at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    /// Number of bytes that are left.
    pub(super) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The next word of the line, `None` at its end or at a comment. Steps over a backslash that ends a line.
    #[inline]
    pub(super) fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            match *self.bytes.get(self.at)? {
                b if is_blank(b) => self.at += 1,
                b'\n' | b'\r' | b'#' => return None,
                b'\\' if self.is_line_end(self.at + 1) => {
                    self.at += 1;
                    self.skip_line();
                }
                _ => break,
            }
        }
        let start = self.at;
        while let Some(&b) = self.bytes.get(self.at) {
            // Almost all bytes pass the first test.
            if (b <= b' ' || b == b'\\')
                && (is_blank(b)
                    || matches!(b, b'\n' | b'\r')
                    || b == b'\\' && self.is_line_end(self.at + 1))
            {
                break;
            }
            self.at += 1;
        }
        Some(&self.bytes[start..self.at])
    }

    /// The next word, on whatever line it stands.
    #[inline]
    pub(super) fn next_on_any_line(&mut self) -> Option<&'a [u8]> {
        loop {
            if let Some(word) = self.next() {
                return Some(word);
            }
            if self.is_at_end() {
                return None;
            }
            self.skip_line();
        }
    }

    /// The rest of the line as it stands, blanks and comments included.
    pub(super) fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        self.at += end;
        &rest[..end]
    }

    /// Steps to the beginning of the next line. A backslash joins no lines here, so that a comment or a
    /// path that ends in one does not swallow the line below.
    #[inline]
    pub(super) fn skip_line(&mut self) {
        let rest = &self.bytes[self.at..];
        match rest.iter().position(|b| matches!(b, b'\n' | b'\r')) {
            Some(end) => {
                self.at += end + if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
                self.line = self.line.saturating_add(1);
            }
            None => self.at = self.bytes.len(),
        }
    }

    fn is_line_end(&self, at: usize) -> bool {
        matches!(self.bytes.get(at), None | Some(b'\n' | b'\r'))
    }
}

/// The rest of a line without blanks around it; a number sign that stands alone begins a comment.
pub(super) fn without_comment(rest: &[u8]) -> &[u8] {
    let comment = rest.windows(3).position(|three| matches!(three, [b' ' | b'\t', b'#', b' ']));
    rest[..comment.unwrap_or(rest.len())].trim_ascii()
}

#[inline]
pub(super) fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | b'\x0b' | b'\x0c')
}
