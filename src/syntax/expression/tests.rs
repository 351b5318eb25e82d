//! Tests of the expression grammar, its error messages and its limits.

use super::{Expression, Node, parse};
use crate::diagnostic::Code;
use crate::text::{Source, Span};
use crate::{Token, TokenKind};

/// Formats the tree of an expression with all its parentheses.
fn tree(text: &str) -> String {
    let expression = Expression::parse_str(text).unwrap();
    show(&expression, &expression.root)
}

fn show(whole: &Expression, node: &Node) -> String {
    match node {
        Node::Literal(k) => whole.literals[*k].value.to_string(),
        Node::Constant(constant) => format!("{constant:?}"),
        Node::Name(function) => function.name.to_string(),
        Node::Negate(inner) => format!("-({})", show(whole, inner)),
        Node::Binary(operator, a, b) => {
            format!("{operator:?}({}, {})", show(whole, a), show(whole, b))
        }
        Node::If(parts) => {
            let parts: Vec<_> = parts.iter().map(|part| show(whole, part)).collect();
            format!("If({})", parts.join("; "))
        }
        Node::Vector(parts) => {
            let parts: Vec<_> = parts.iter().map(|part| show(whole, part)).collect();
            format!("[{}]", parts.join(", "))
        }
        Node::Call {
            function,
            arguments,
            ..
        } => {
            let parts: Vec<_> = arguments.iter().map(|part| show(whole, part)).collect();
            format!("{}({})", function.name, parts.join(", "))
        }
    }
}

#[test]
fn vectors_are_read() {
    // operators.html: vectors of scalars; the cross product has the precedence of * and associates to the left.
    assert_eq!(
        tree("MAG(DXYZ(4,5)%FXYZ(4))+[1,2,3]*UV([0,1,0])"),
        "Add(MAG(Cross(DXYZ(4, 5), FXYZ(4))), Multiply([1, 2, 3], UV([0, 1, 0])))"
    );
    assert_eq!(tree("-2**-3**-2"), "-(Power(2, -(Power(3, -(2)))))");
    for wrong in ["[1,2]", "[1,2,3,4]", "[1,2,3", "1%"] {
        let error = Expression::parse_str(wrong).unwrap_err();
        assert_eq!(error.code, Code::BadExpression, "{wrong}");
    }
}

#[test]
fn powers_bind_tighter_than_signs_and_to_the_right() {
    // guide/formats.md 3.1: precedence as in FORTRAN, where the power binds more tightly than the sign.
    assert_eq!(tree("-2**2"), "-(Power(2, 2))");
    assert_eq!(tree("2**3**2"), "Power(2, Power(3, 2))");
    assert_eq!(tree("2**-1"), "Power(2, -(1))");
    // A signed number in parentheses is one literal.
    assert_eq!(tree("2 * * (-1.)"), "Power(2, -1)");
    assert_eq!(tree("8/4/2"), "Divide(Divide(8, 4), 2)");
    assert_eq!(tree("1-2-3*4"), "Subtract(Subtract(1, 2), Multiply(3, 4))");
    assert_eq!(tree("2*-3"), "Multiply(2, -(3))");
}

#[test]
fn names_and_choices_are_read_in_any_case() {
    assert_eq!(tree("pi*rtod"), "Multiply(Pi, Rtod)");
    assert_eq!(
        tree("if( 1 :2, If(3:4,5,6) , 7)"),
        "If(1; 2; If(3; 4; 5; 6); 7)"
    );
}

#[test]
fn degrees_become_radians_and_keep_their_place() {
    let expression = Expression::parse_str("1.5 - 90D").unwrap();
    assert_eq!(expression.literals.len(), 2);
    assert!(expression.literals[1].degrees);
    assert!((expression.literals[1].value - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert_eq!(expression.literals[1].span, Span::new(6, 9));
}

#[test]
fn trouble_is_shown_at_its_place() {
    for (text, at, says) in [
        ("", Span::new(0, 0), "empty"),
        ("1+", Span::at(2), "ends where an operand"),
        ("(1", Span::new(0, 1), "`)` is missing"),
        ("1)", Span::new(1, 2), "`)` is not expected"),
        ("2^3", Span::new(1, 2), "`^` is not expected"),
        ("IF(1,2,3)", Span::new(4, 5), "colon"),
        ("20 D", Span::new(3, 4), "`D` is not expected"),
        ("1..2", Span::new(2, 4), "`.2` is not expected"),
        ("1,2", Span::new(1, 2), "`,` is not expected"),
    ] {
        let error = Expression::parse_str(text).unwrap_err();
        assert_eq!(error.code, Code::BadExpression);
        assert_eq!(error.labels[0].span, at, "{text}: {}", error.message);
        assert!(error.message.contains(says), "{text}: {}", error.message);
    }
}

#[test]
fn depth_is_limited_and_size_is_not() {
    for text in [
        "(".repeat(10_000_000),
        "-".repeat(10_000_000),
        "2**".repeat(1_000_000),
        "IF(".repeat(1_000_000),
        "1+".repeat(5_000_000),
    ] {
        let error = Expression::parse_str(&text).unwrap_err();
        assert!(error.message.contains("more than"), "{}", error.message);
    }
    let wide = vec!["1"; 1000].join("+");
    assert_eq!(Expression::parse_str(&wide).unwrap().literals.len(), 1000);
    let deep = format!("{}1{}", "(".repeat(300), ")".repeat(300));
    assert_eq!(tree(&deep), "1");
    // Each IF in parentheses adds two levels of nesting.
    let ifs = format!("{}1{}", "(IF(TIME-1:0,0,".repeat(149), "))".repeat(149));
    assert!(Expression::parse_str(&ifs).is_ok());
}

#[test]
fn any_text_is_read_or_complained_about() {
    // Pieces of expressions in random order, from a linear congruential generator.
    const PIECES: [&str; 24] = [
        "1", "2.5E3", "90D", "+", "-", "*", "/", "**", "(", ")", ",", ":", "IF(", "STEP(", "DX(",
        "TIME", "PI", "SQRT(", " ", "\n", "&", "x", "\u{e9}", "MAX(",
    ];
    let mut state = 1u64;
    let mut read = 0;
    for _ in 0..20_000 {
        let mut text = String::new();
        for _ in 0..=state % 9 {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            text.push_str(PIECES[(state >> 33) as usize % PIECES.len()]);
        }
        match Expression::parse_str(&text) {
            Ok(expression) => {
                read += 1;
                let again = Expression::parse_str(&expression.text).unwrap();
                assert_eq!(
                    show(&again, &again.root),
                    show(&expression, &expression.root)
                );
            }
            Err(error) => assert!(error.labels[0].span.end() <= text.len(), "{text}"),
        }
    }
    assert!(read > 500, "{read}");
}

#[test]
fn comments_and_continuation_marks_are_blanks() {
    // The function text `1 +! half`, `, 2&`, `*3` on three lines, with the tokens that a lexer produces for it.
    let source = Source::new("deck.adm", b"1 +! half\n, 2&\n*3".to_vec());
    let kinds = [
        (TokenKind::Number, 1),
        (TokenKind::Blank, 1),
        (TokenKind::Punctuation(b'+'), 1),
        (TokenKind::Comment, 6),
        (TokenKind::LineEnd, 1),
        (TokenKind::Continuation, 1),
        (TokenKind::Blank, 1),
        (TokenKind::Number, 1),
        (TokenKind::Punctuation(b'&'), 1),
        (TokenKind::LineEnd, 1),
        (TokenKind::Punctuation(b'*'), 1),
        (TokenKind::Number, 1),
    ];
    let mut at = 0;
    let tokens: Vec<Token> = kinds
        .into_iter()
        .map(|(kind, length)| {
            at += length;
            Token {
                kind,
                span: Span::new(at - length, at),
            }
        })
        .collect();
    let checked = parse(&source, &tokens, Span::new(0, at));
    let expression = checked.value.unwrap();
    assert_eq!(expression.text, "1 + 2 *3");
    assert_eq!(
        show(&expression, &expression.root),
        "Add(1, Multiply(2, 3))"
    );
}
