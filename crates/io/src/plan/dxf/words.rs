//! What does a text of a drawing say? Its words without what sets them: `{\fArial|b1;OFFICE}\P%%u101%%u` is OFFICE, and 101 below it.

/// Characters kept of one text; a label has some ten, a note on the sheet some hundred.
const LONGEST: usize = 1000;
/// Characters looked at: its formats may be longer than the text itself.
const LOOKED_AT: usize = 10_000;

/// The words of a `TEXT`, which knows `%%` and `\U+` only.
pub(super) fn of_text(raw: &str) -> String {
    plain(raw, false)
}

/// The words of an `MTEXT`, one line a paragraph.
pub(super) fn of_mtext(raw: &str) -> String {
    plain(raw, true)
}

fn plain(raw: &str, formatted: bool) -> String {
    let mut words = String::new();
    let mut rest = raw.char_indices().nth(LOOKED_AT).map_or(raw, |(end, _)| &raw[..end]);
    while words.len() < LONGEST
        && let Some(first) = rest.chars().next()
    {
        let (text, after) = match first {
            '%' => percent(rest),
            '\\' => backslash(rest, formatted),
            '^' if formatted => caret(rest),
            '{' | '}' if formatted => (None, &rest[1..]),
            other => (Some(other), &rest[other.len_utf8()..]),
        };
        words.extend(text);
        rest = after;
    }
    let lines = words.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "));
    lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("\n")
}

/// `%%d`, `%%c`, `%%p`, `%%nnn`; `%%u` and such only draw lines.
fn percent(text: &str) -> (Option<char>, &str) {
    let Some(code) = text.strip_prefix("%%") else { return (Some('%'), &text[1..]) };
    let digits = code.bytes().take(3).take_while(u8::is_ascii_digit).count();
    if digits > 0 {
        let (number, after) = code.split_at(digits);
        return (number.parse().ok().and_then(char::from_u32).filter(|c| !c.is_control()), after);
    }
    let Some(letter) = code.chars().next() else { return (None, code) };
    let after = &code[letter.len_utf8()..];
    match letter.to_ascii_lowercase() {
        'd' => (Some('°'), after),
        'c' => (Some('⌀'), after),
        'p' => (Some('±'), after),
        '%' => (Some('%'), after),
        'u' | 'o' | 'k' => (None, after),
        _ => (Some('%'), &text[1..]),
    }
}

/// `^J` and `^M` are line feeds that were escaped, `^I` is a tabulator; `^ ` is the character itself.
fn caret(text: &str) -> (Option<char>, &str) {
    match text.as_bytes().get(1) {
        Some(b'J' | b'M') => (Some('\n'), &text[2..]),
        Some(b'I') => (Some(' '), &text[2..]),
        Some(b' ') => (Some('^'), &text[2..]),
        _ => (Some('^'), &text[1..]),
    }
}

fn backslash(text: &str, formatted: bool) -> (Option<char>, &str) {
    let code = &text[1..];
    if let Some(hex) = code.strip_prefix("U+").or_else(|| code.strip_prefix("u+"))
        && let Some((hex, after)) = hex.split_at_checked(4)
        && let Ok(number) = u32::from_str_radix(hex, 16)
    {
        return (char::from_u32(number), after);
    }
    let Some(letter) = code.chars().next().filter(|_| formatted) else { return (Some('\\'), code) };
    let after = &code[letter.len_utf8()..];
    match letter {
        'P' | 'N' | 'X' => (Some('\n'), after),
        '~' => (Some(' '), after),
        '\\' | '{' | '}' => (Some(letter), after),
        'L' | 'l' | 'O' | 'o' | 'K' | 'k' => (None, after),
        // Fonts, heights, colours, tabulators: up to the semicolon, or else only the letter.
        'f' | 'F' | 'H' | 'C' | 'c' | 'T' | 'Q' | 'W' | 'A' | 'p' => match after.split_once(';') {
            Some((_, after)) => (None, after),
            None => (None, after),
        },
        // Stacked: what stands between is drawn.
        'S' => (None, after),
        _ => (Some('\\'), code),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn formats_go_and_words_stay() {
        for (raw, words) in [
            ("101", "101"),
            (r"{\fArial|b1|i0|c0|p34;OFFICE}\P\H2.5;101", "OFFICE\n101"),
            (r"\A1;\C7;Caf\U+00E9\~2", "Café 2"),
            (r"\pxi-3,l4;a\\b \{c\}", r"a\b {c}"),
            (r"{\LStairs\l}", "Stairs"),
            (r"first^Jsecond^ third", "first\nsecond^third"),
            (r"90%%d %%c5 %%p1 100%%% 5%", "90° ⌀5 ±1 100% 5%"),
            (r"\P\P  two   words \P", "two words"),
            ("", ""),
            (r"\", r"\"),
            (r"\H", ""),
            ("%%", ""),
        ] {
            assert_eq!(of_mtext(raw), words, "{raw}");
        }
        assert_eq!(of_text(r"%%uB%%u {C:\Plan}"), r"B {C:\Plan}");
        assert_eq!(of_text(r"Gr\U+00F6\U+00DFe %%065"), "Größe A");
    }

    #[test]
    fn a_book_is_cut() {
        assert!(of_text(&"x".repeat(100_000)).len() <= LONGEST);
    }

    proptest! {
        #[test]
        fn anything_gives_something(raw in ".*", codes in r"(\\|%|\^|\{|U\+|[a-zA-Z0-9;é])*") {
            of_mtext(&raw);
            of_text(&codes);
            of_mtext(&codes);
        }
    }
}
