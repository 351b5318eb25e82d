//! Changes of values in a dataset, as text edits that touch only the bytes that change.

use std::collections::BTreeSet;

use super::expression::Node;
use super::new_statement::NewStatement;
use super::number::parse_number;
use super::spelling::spell_like;
use super::style::Style;
use super::{Address, Argument, Dataset, Expression, Number, Statement, Value};
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::{ArgumentDef, ValueKind};
use crate::text::{Edit, Span};

impl Dataset {
    /// Returns the statement that an address refers to.
    pub fn find(&self, address: &Address) -> Option<&Statement> {
        self.statement(&address.kind, address.id)
    }

    /// Returns the number that an address refers to, if it is written in the file.
    ///
    /// The number is value `index` of an argument, literal `index` in the text of a function, or the value of a function that consists of a
    /// single number. If the address has no argument name, FUNCTION is used. The index may be omitted if there is only one value.
    pub fn number_at(&self, address: &Address) -> Option<Number> {
        let statement = self.find(address)?;
        let name = address.argument.as_deref().unwrap_or("FUNCTION");
        match (&statement.argument(name)?.value, address.index) {
            (Value::Function(expression), Some(index)) => {
                expression.literals.get(index - 1).copied()
            }
            (Value::Function(expression), None) => constant(expression),
            (_, index) => {
                let numbers = || statement.all(name).flat_map(Argument::numbers);
                match index {
                    Some(index) => numbers().nth(index - 1).copied(),
                    None if numbers().count() == 1 => numbers().next().copied(),
                    None => None,
                }
            }
        }
    }

    /// Returns the number that an address refers to, or its default in the grammar if the argument is not written.
    pub fn value_at(&self, address: &Address) -> Option<f64> {
        if let Some(number) = self.number_at(address) {
            return Some(number.value);
        }
        let statement = self.find(address)?;
        let def = argument_def(statement, address)?;
        if statement.has(def.name) {
            return None;
        }
        match (address.index, def.default) {
            (Some(index), values) => values.get(index - 1).copied(),
            (None, [value]) => Some(*value),
            (None, _) => None,
        }
    }

    /// Returns the edits that set a number to a new value in model units (angles in radians). There are no edits if the value is unchanged.
    ///
    /// Only the bytes of the number change, and its style is kept. An argument that is not written is added in the style of the file. If QP
    /// of a marker is set, its points ZP and XP move along, so that the marker does not rotate.
    ///
    /// # Errors
    /// Returns `undefined-id` if the object does not exist, `wrong-type` if the address does not refer to a number, and `out-of-range` for
    /// a value that cannot be written there.
    pub fn set(&self, address: &Address, value: f64) -> Result<Vec<Edit>, Diagnostic> {
        self.set_beside(address, value, &BTreeSet::new())
    }

    /// Returns the edits of [`Dataset::set`] for one of several assignments made together.
    ///
    /// `beside` contains all addresses that are assigned. A point ZP or XP in `beside` gets its own value and does not move along with QP.
    ///
    /// # Errors
    /// Returns the errors of [`Dataset::set`].
    pub fn set_beside(
        &self,
        address: &Address,
        value: f64,
        beside: &BTreeSet<&Address>,
    ) -> Result<Vec<Edit>, Diagnostic> {
        let mut edits = self.set_alone(address, value)?;
        edits.extend(self.move_points(address, &[value], beside)?);
        Ok(edits)
    }

    /// Returns the edits that set only this number; the points ZP and XP of a marker do not move along with QP.
    ///
    /// # Errors
    /// Returns the errors of [`Dataset::set`].
    pub(crate) fn set_alone(&self, address: &Address, value: f64) -> Result<Vec<Edit>, Diagnostic> {
        self.set_spelled(address, value, |old| spell_like(value, old))
    }

    /// Returns the edits that set the value at an address to a text typed by a user.
    ///
    /// A typed number keeps its spelling, with two exceptions. Typed radians that replace degrees are converted to degrees, and a number
    /// that replaces one with an exponent gets an exponent. The points ZP and XP of a marker move as described at [`Dataset::set_beside`].
    ///
    /// # Errors
    /// Returns the errors of [`Dataset::set`] and [`Dataset::set_text`].
    pub fn set_typed(
        &self,
        address: &Address,
        typed: &str,
        beside: &BTreeSet<&Address>,
    ) -> Result<Vec<Edit>, Diagnostic> {
        let Some((value, degrees)) = parse_number(typed.as_bytes()) else {
            let mut edits = self.set_text(address, typed)?;
            let words = typed.split(',');
            let values = words.map(|word| Some(parse_number(word.trim().as_bytes())?.0));
            if let Some(values) = values.collect::<Option<Vec<f64>>>() {
                edits.extend(self.move_points(address, &values, beside)?);
            }
            return Ok(edits);
        };
        let mut edits = self.set_spelled(address, value, |old| {
            // An angle in degrees stays in degrees, and an exponent stays an exponent, so that the number keeps its unit and style.
            let in_degrees = !degrees && matches!(old, [.., b'D' | b'd']);
            let has_power = |text: &[u8]| text.iter().any(|byte| matches!(byte, b'E' | b'e'));
            if in_degrees || has_power(old) && !has_power(typed.as_bytes()) {
                spell_like(value, old)
            } else {
                typed.to_string()
            }
        })?;
        edits.extend(self.move_points(address, &[value], beside)?);
        Ok(edits)
    }

    /// Returns the edits that set a number to a new value; `spell` formats the new value in the style of the old spelling.
    fn set_spelled(
        &self,
        address: &Address,
        value: f64,
        spell: impl Fn(&[u8]) -> String,
    ) -> Result<Vec<Edit>, Diagnostic> {
        let statement = self.find(address).ok_or_else(|| self.absent(address))?;
        let place = statement.keyword;
        if !value.is_finite() {
            return Err(self.refuse(
                Code::OutOfRange,
                format!("{address} must be a finite number, not {value}"),
                place,
            ));
        }
        if let Some(number) = self.number_at(address) {
            if number.value == value {
                return Ok(Vec::new());
            }
            let def = argument_def(statement, address);
            if def.is_some_and(is_whole) && value.fract() != 0.0 {
                return Err(self.refuse(
                    Code::WrongType,
                    format!("{address} must be a whole number, not {value}"),
                    number.span,
                ));
            }
            let inside =
                def.is_some_and(|def| def.kind == ValueKind::Function) && address.index.is_some();
            let old = self.source().slice(number.span);
            if def.is_some_and(is_whole) {
                return Ok(vec![Edit::new(number.span, spell_like(value, old))]);
            }
            let spelled = spell(old);
            if !inside {
                return Ok(vec![Edit::new(number.span, spelled)]);
            }
            let spelled = spelled.trim_start_matches('+');
            if is_id(statement, address) && (value < 0.0 || value.fract() != 0.0) {
                return Err(self.refuse(
                    Code::WrongType,
                    format!("{address} must be an id, not {value}"),
                    number.span,
                ));
            }
            // A negative number is enclosed in parentheses so that two operators are never adjacent.
            return Ok(vec![if value < 0.0 && !old.starts_with(b"-") {
                Edit::new(number.span, format!("({spelled})"))
            } else {
                Edit::new(number.span, spelled)
            }]);
        }
        let Some(def) = argument_def(statement, address) else {
            return Err(self.refuse(
                Code::WrongType,
                format!("{address} is not the address of a number"),
                place,
            ));
        };
        match (def.kind, statement.argument(def.name)) {
            (ValueKind::Function, _) if address.index.is_none() => {
                self.set_text(address, &spell(b"1.0"))
            }
            (ValueKind::Real | ValueKind::Integer, written) => {
                self.extend(statement, def, written, address, value, spell)
            }
            _ => Err(self.refuse(
                Code::WrongType,
                format!("{address} is not the address of a number"),
                place,
            )),
        }
    }

    /// Returns the edits that replace the whole value of an argument by a text, which is a function, a word or a list.
    ///
    /// If the address has no argument name, FUNCTION is used. An argument that is not written is added.
    ///
    /// # Errors
    /// Returns `undefined-id` if the object does not exist, and `bad-expression` for a function that cannot be parsed. Returns
    /// `syntax-error` for a text with a line end, `;` or `!`, and `wrong-type` for a flag or an address with an index.
    pub fn set_text(&self, address: &Address, text: &str) -> Result<Vec<Edit>, Diagnostic> {
        if address.kind == "TITLE" {
            return self.set_title(text);
        }
        let statement = self.find(address).ok_or_else(|| self.absent(address))?;
        let def = argument_def(statement, address)
            .filter(|def| def.kind != ValueKind::Flag && address.index.is_none());
        let Some(def) = def else {
            return Err(self.refuse(
                Code::WrongType,
                format!("{address} does not name an argument with a value"),
                statement.keyword,
            ));
        };
        let unquoted = text.split('"').step_by(2);
        if text.contains(['\n', '\r']) || unquoted.clone().any(|part| part.contains([';', '!'])) {
            return Err(self.refuse(
                Code::SyntaxError,
                format!(
                    "{} cannot contain a line break, a semicolon or an exclamation mark",
                    def.name
                ),
                statement.keyword,
            ));
        }
        let is_user = text.trim_start().to_ascii_uppercase().starts_with("USER");
        if def.kind == ValueKind::Function && !is_user {
            Expression::parse_str(text)?;
        }
        match statement.argument(def.name) {
            Some(argument) if argument.value != Value::Flag => {
                let span = argument.value_span();
                if self.source().slice(span) == text.as_bytes() {
                    return Ok(Vec::new());
                }
                Ok(vec![Edit::new(span, self.encoded(text))])
            }
            _ => Ok(vec![self.new_argument(statement, def.name, Some(text))]),
        }
    }

    /// Returns the edits that add a flag to a statement (`on`), or remove it together with its separator.
    ///
    /// # Errors
    /// Returns `undefined-id` if the object does not exist, and `wrong-type` if the address does not refer to a flag.
    pub fn set_flag(&self, address: &Address, on: bool) -> Result<Vec<Edit>, Diagnostic> {
        let statement = self.find(address).ok_or_else(|| self.absent(address))?;
        let def = argument_def(statement, address)
            .filter(|def| def.kind == ValueKind::Flag && address.index.is_none());
        let Some(def) = def else {
            return Err(self.refuse(
                Code::WrongType,
                format!("{address} is not the address of a flag"),
                statement.keyword,
            ));
        };
        Ok(match (statement.has(def.name), on) {
            (false, true) => vec![self.new_argument(statement, def.name, None)],
            (true, false) => statement
                .every(def.name)
                .map(|argument| self.without(statement, argument))
                .collect(),
            _ => Vec::new(),
        })
    }

    /// Encodes a text in the encoding of the file ([`Source::encoded`](crate::text::Source::encoded)).
    pub(super) fn encoded(&self, text: &str) -> Vec<u8> {
        self.source().encoded(text)
    }

    /// Returns the edits that add a statement in the style of the file: after the last statement of its kind, or before END if there is
    /// none.
    ///
    /// Markers that name no body belong to the body before them. A new body is therefore inserted only after all such markers of the
    /// preceding body.
    pub fn add(&self, statement: &NewStatement) -> Vec<Edit> {
        let style = Style::of(self);
        let text = style.statement(statement);
        let kind = Some(statement.kind.as_str());
        let body = self
            .statements()
            .iter()
            .any(|other| other.kind() == kind && other.carries_markers());
        let same = self
            .statements()
            .iter()
            .rfind(|other| other.kind() == kind || body && other.follows_body());
        let (at, text) = match (same, self.end()) {
            (Some(other), _) => self.after_line(other.span.end(), &text, &style),
            (None, Some(end)) => (self.line_start(end.span.start()), text),
            (None, None) => self.after_line(self.bytes().len(), &text, &style),
        };
        vec![Edit::new(Span::at(at), self.encoded(&text))]
    }

    /// Formats a statement in the style of this dataset, without a final line end.
    pub fn written(&self, statement: &NewStatement) -> Vec<u8> {
        let text = Style::of(self).statement(statement);
        self.encoded(text.trim_end())
    }

    /// Returns the END statement, if the dataset has one.
    pub fn end(&self) -> Option<&Statement> {
        self.statements().last().filter(|last| {
            self.source()
                .slice(last.keyword)
                .eq_ignore_ascii_case(b"END")
        })
    }

    /// Returns the edits that extend a list of numbers up to the addressed position; the positions in between get their default values.
    fn extend(
        &self,
        statement: &Statement,
        def: &'static ArgumentDef,
        written: Option<&Argument>,
        address: &Address,
        value: f64,
        spell: impl Fn(&[u8]) -> String,
    ) -> Result<Vec<Edit>, Diagnostic> {
        let numbers = written.map_or(&[][..], Argument::numbers);
        let index = address.index.unwrap_or(1);
        let too_far = def.count.max.is_some_and(|max| index > max) || index > numbers.len() + 36;
        let unreadable = written.is_some_and(|_| numbers.is_empty());
        let unclear = address.index.is_none() && (numbers.len() > 1 || def.count.min > 1);
        let is_fraction = is_whole(def) && value.fract() != 0.0;
        if too_far || unreadable || unclear || is_fraction {
            let message = if unreadable {
                format!("the present value of {address} is not a list of numbers")
            } else if unclear {
                format!("{address} has several values: add an index, such as {address}.1")
            } else if too_far {
                format!("the index of {address} is too large")
            } else {
                format!("{address} must be a whole number, not {value}")
            };
            return Err(self.refuse(
                Code::OutOfRange,
                message,
                written.map_or(statement.keyword, |argument| argument.span),
            ));
        }
        let old = match numbers.last() {
            Some(number) => self.source().slice(number.span).to_vec(),
            None if is_whole(def) => b"1".to_vec(),
            None => b"1.0".to_vec(),
        };
        let length = index.max(def.count.min.max(def.default.len()).min(index + 36));
        let values: Vec<String> = (numbers.len()..length)
            .map(|k| {
                let default = def.default.get(k).copied().unwrap_or(0.0);
                match (k + 1 == index, is_whole(def)) {
                    (true, false) => spell(&old),
                    (true, true) => spell_like(value, &old),
                    (false, _) => spell_like(default, &old),
                }
            })
            .collect();
        let text = values.join(", ");
        Ok(vec![match numbers.last() {
            Some(last) => Edit::new(Span::at(last.span.end()), format!(", {text}")),
            None => self.new_argument(statement, def.name, Some(&text)),
        }])
    }

    /// Returns the edit that adds `NAME = text`, or a flag without a value, at the end of a statement.
    pub(super) fn new_argument(
        &self,
        statement: &Statement,
        name: &str,
        text: Option<&str>,
    ) -> Edit {
        let style = Style::of_statement(self, statement);
        let last = statement.arguments.last();
        let mut at = last.map_or_else(
            || self.after_header(statement),
            |argument| argument.span.end(),
        );
        let mut lead = String::new();
        let is_function = last.is_some_and(|argument| {
            matches!(argument.value, Value::Function(_) | Value::User(_))
                || (matches!(argument.value, Value::Malformed(_))
                    && argument
                        .def
                        .is_some_and(|def| def.kind == ValueKind::Function))
        });
        if is_function {
            // A function followed by another argument must end with a backslash, which may already be present.
            let rest = &self.bytes()[at..statement.span.end()];
            match rest.iter().position(|byte| !byte.is_ascii_whitespace()) {
                Some(mark) if rest[mark] == b'\\' => at += mark + 1,
                _ => lead.push('\\'),
            }
        }
        Edit::new(
            Span::at(at),
            self.encoded(&format!("{lead}{}", style.argument(name, text))),
        )
    }

    /// Returns the offset at which the head `KEYWORD/id` of a statement ends.
    pub(super) fn after_header(&self, statement: &Statement) -> usize {
        if let Some((_, span)) = statement.id {
            return span.end();
        }
        let rest = &self.bytes()[statement.keyword.end()..statement.span.end()];
        match rest.iter().position(|byte| !byte.is_ascii_whitespace()) {
            Some(slash) if rest[slash] == b'/' => statement.keyword.end() + slash + 1,
            _ => statement.keyword.end(),
        }
    }

    pub(super) fn absent(&self, address: &Address) -> Diagnostic {
        let object = Address {
            argument: None,
            index: None,
            ..address.clone()
        };
        self.refuse(
            Code::UndefinedId,
            format!("{object} is not in this dataset"),
            self.title_span(),
        )
    }

    pub(super) fn refuse(&self, code: Code, message: String, span: Span) -> Diagnostic {
        Diagnostic::error(code, message).label(self.source().name(), span, "")
    }

    pub(super) fn line_start(&self, at: usize) -> usize {
        memchr::memrchr2(b'\n', b'\r', &self.bytes()[..at]).map_or(0, |end| end + 1)
    }

    /// Returns the offset of the line after the line that contains `at`.
    pub(super) fn line_end(&self, at: usize) -> usize {
        super::lines::physical_line(self.bytes(), at).next
    }

    /// Returns the offset and the text of an insertion that puts `text` after the line of `at`. If that line has no line end, the inserted
    /// text begins with one.
    fn after_line(&self, at: usize, text: &str, style: &Style) -> (usize, String) {
        let next = self.line_end(at);
        let open = !matches!(self.bytes()[..next].last(), None | Some(b'\n' | b'\r'));
        if open {
            (next, format!("{}{text}", style.line_end))
        } else {
            (next, text.to_string())
        }
    }
}

fn argument_def(statement: &Statement, address: &Address) -> Option<&'static ArgumentDef> {
    let name = address.argument.as_deref().unwrap_or("FUNCTION");
    statement
        .def?
        .arguments
        .iter()
        .find(|argument| argument.name == name)
}

/// Returns true if the address refers to a number inside a function and this number is an id.
fn is_id(statement: &Statement, address: &Address) -> bool {
    let name = address.argument.as_deref().unwrap_or("FUNCTION");
    let (Some(argument), Some(index)) = (statement.argument(name), address.index) else {
        return false;
    };
    match &argument.value {
        Value::Function(expression) => expression
            .references()
            .iter()
            .any(|(_, literal)| literal + 1 == index),
        _ => false,
    }
}

const fn is_whole(def: &'static ArgumentDef) -> bool {
    matches!(def.kind, ValueKind::Integer | ValueKind::Reference(_))
}

/// Returns the value of a function that consists of a single number, with or without a minus sign.
fn constant(expression: &Expression) -> Option<Number> {
    let (literal, sign) = match &expression.root {
        Node::Literal(literal) => (literal, 1.0),
        Node::Negate(inner) => match &**inner {
            Node::Literal(literal) => (literal, -1.0),
            _ => return None,
        },
        _ => return None,
    };
    let number = expression.literals[*literal];
    Some(Number {
        value: sign * number.value,
        degrees: number.degrees,
        span: expression.span,
    })
}
