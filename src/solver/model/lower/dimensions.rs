//! Check that matrices and arrays have the sizes that the statements using them need (state_array, fstate_lse).

use super::reader::Context;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::grammar::StatementDef;
use admire_syntax::{Stated, as_id};

/// Checks the sizes of matrices and arrays in one statement of a dataset.
pub(super) fn check(
    statement: Stated,
    def: &'static StatementDef,
    context: Context,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let mut sizes = Sizes {
        statement,
        context,
        diagnostics,
        called: match statement.number() {
            Some(id) => format!("{}/{id}", def.name),
            None => def.name.to_string(),
        },
    };
    match def.name {
        "MATRIX" => sizes.matrix(),
        "ARRAY" => sizes.array(),
        "LSE" => sizes.linear_states(),
        "TFSISO" => sizes.transfer_function(),
        _ => {}
    }
}

struct Sizes<'a> {
    statement: Stated<'a>,
    context: Context<'a>,
    diagnostics: &'a mut Vec<Diagnostic>,
    called: String,
}

impl<'a> Sizes<'a> {
    fn complain(&mut self, argument: &str, message: String) {
        let (source, place) = self.statement.place(argument);
        self.diagnostics
            .push(Diagnostic::error(Code::WrongCount, message).label(source.name(), place, ""));
    }

    fn whole(statement: Stated, name: &str) -> Option<usize> {
        let value = statement.first(name)?;
        (value >= 1.0 && value.fract() == 0.0).then_some(value as usize)
    }

    fn matrix(&mut self) {
        let statement = self.statement;
        let count = |name: &str| statement.numbers(name).len();
        let values = count("VALUES");
        let (rows, columns) = (
            Self::whole(statement, "ROWS"),
            Self::whole(statement, "COLUMNS"),
        );
        if values == 0 {
            return;
        }
        if statement.has("SPARSE") {
            for name in ["I", "J"] {
                if count(name) != values {
                    let message = format!(
                        "{}: {name} has {} values but VALUES has {values}; each value needs its row I and its column J",
                        self.called,
                        count(name)
                    );
                    self.complain(name, message);
                }
            }
            for (name, most) in [("I", rows), ("J", columns)] {
                let Some(most) = most else { continue };
                let beyond = statement
                    .numbers(name)
                    .iter()
                    .find(|n| n.value < 1.0 || n.value > most as f64);
                if let Some(number) = beyond {
                    let message = format!(
                        "{}: {name} contains {}, but must be between 1 and {most}",
                        self.called, number.value
                    );
                    self.complain(name, message);
                }
            }
        } else if let (Some(rows), Some(columns)) = (rows, columns)
            && rows.checked_mul(columns) != Some(values)
        {
            let message = format!(
                "{}: {rows} rows and {columns} columns need {} values, not {values}",
                self.called,
                rows.saturating_mul(columns)
            );
            self.complain("VALUES", message);
        }
    }

    fn array(&mut self) {
        let Some(size) = Self::whole(self.statement, "SIZE") else {
            return;
        };
        for name in ["NUMBERS", "VARIABLES"] {
            let count = self.statement.numbers(name).len();
            if count > 0 && count != size {
                let (source, place) = self.statement.place("SIZE");
                self.diagnostics.push(
                    Diagnostic::warning(
                        Code::WrongCount,
                        format!(
                            "{}: SIZE = {size}, but {name} has {count} values",
                            self.called
                        ),
                    )
                    .label(source.name(), place, "")
                    .help(format!("the {count} values are used")),
                );
            }
        }
    }

    /// Returns the numbers of rows and columns of the MATRIX that an argument names, if the MATRIX states both.
    fn of_matrix(&self, argument: &str) -> Option<(usize, usize)> {
        let matrix = self.named("MATRIX", argument)?;
        Some((
            Self::whole(matrix, "ROWS")?,
            Self::whole(matrix, "COLUMNS")?,
        ))
    }

    fn named(&self, kind: &'static str, argument: &str) -> Option<Stated<'a>> {
        let id = as_id(self.statement.first(argument)?)?;
        self.context.stated(kind, id)
    }

    /// Returns the number of elements of the ARRAY that an argument names. Returns `None` if the ARRAY does not give its size.
    fn of_array(&self, argument: &str) -> Option<usize> {
        let array = self.named("ARRAY", argument)?;
        let given = |name: &str| Some(array.numbers(name).len()).filter(|count| *count > 0);
        given("VARIABLES")
            .or_else(|| given("NUMBERS"))
            .or_else(|| Self::whole(array, "SIZE"))
    }

    fn linear_states(&mut self) {
        let Some((rows, columns)) = self.of_matrix("A") else {
            return;
        };
        if rows != columns {
            let message = format!(
                "{}: A has {rows} rows and {columns} columns; it must be square",
                self.called
            );
            self.complain("A", message);
            return;
        }
        let states = rows;
        for name in ["X", "IC"] {
            let of = if states == 1 {
                "state of A"
            } else {
                "states of A"
            };
            self.array_has(name, states, of);
        }
        let (inputs, outputs) = (self.of_array("U"), self.of_array("Y"));
        let outputs = outputs.or_else(|| self.of_matrix("C").or(self.of_matrix("D")).map(|m| m.0));
        for (name, rows, columns) in [
            ("B", Some(states), inputs),
            ("C", outputs, Some(states)),
            ("D", outputs, inputs),
        ] {
            let Some((has_rows, has_columns)) = self.of_matrix(name) else {
                continue;
            };
            let (row_array, column_array) = match name {
                "B" => ("states", "U"),
                "C" => ("Y", "states"),
                _ => ("Y", "U"),
            };
            if name != "C" && inputs.is_none() && self.statement.first("U").is_some() {
                let message = format!(
                    "{}: the size of U, the array of inputs, is unknown; {name} needs it",
                    self.called
                );
                self.complain(name, message);
            }
            for (what, has, wanted, of) in [
                ("rows", has_rows, rows, row_array),
                ("columns", has_columns, columns, column_array),
            ] {
                if let Some(wanted) = wanted.filter(|wanted| *wanted != has) {
                    let message = format!(
                        "{}: the number of {what} of {name} is {has}, not {wanted}, the number of {}",
                        self.called,
                        if of == "states" {
                            "states".to_string()
                        } else {
                            format!("elements in {of}")
                        }
                    );
                    self.complain(name, message);
                }
            }
        }
    }

    fn transfer_function(&mut self) {
        let count = |name: &str| self.statement.numbers(name).len();
        let order = count("DENOMINATOR").saturating_sub(1);
        // Zero coefficients of the highest powers in the denominator add no states.
        let least = self
            .statement
            .numbers("DENOMINATOR")
            .iter()
            .rposition(|number| number.value != 0.0)
            .unwrap_or(0);
        if self
            .of_array("X")
            .is_some_and(|size| !(least..=order).contains(&size))
        {
            let of = if order == 1 {
                "state of the denominator"
            } else {
                "states of the denominator"
            };
            self.array_has("X", order, of);
        }
        for name in ["U", "Y"] {
            self.array_has(name, 1, "signal of a transfer function");
        }
    }

    fn array_has(&mut self, argument: &str, wanted: usize, of: &str) {
        if let Some(has) = self.of_array(argument).filter(|has| *has != wanted) {
            let message = format!(
                "{}: the size of the array {argument} is {has}, but there {} {wanted} {of}",
                self.called,
                if wanted == 1 { "is" } else { "are" }
            );
            self.complain(argument, message);
        }
    }
}
