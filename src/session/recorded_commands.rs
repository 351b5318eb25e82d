//! The commands that a message file records, as a command file: what was asked of ADAMS from outside, as in a co-simulation, can be asked
//! again without it.

/// The commands of a message file (`.msg`) in their order, as the text of a command file; `None` if it records none.
///
/// A line ` command: ...` is one line of commands; lines that are continued with `&` stay so. `FILE/COMMAND=...`, whose lines follow, is left
/// out. Where no FILE/MODEL is recorded, as in co-simulations, `model` is read first. Simulations are repeated with what was set before
/// each of them: where an input was set several times (predictor, corrector) the last one acts.
pub(crate) fn recorded_commands(messages: &str, model: &str) -> Option<String> {
    let lines: Vec<&str> = messages
        .lines()
        .filter_map(|line| line.trim_start().strip_prefix("command:"))
        .map(str::trim)
        .collect();
    let word = |line: &str| line.to_ascii_lowercase().replace(' ', "");
    let names_model = |line: &&str| word(line).starts_with("file/mod");
    let kept: Vec<&str> = lines
        .iter()
        .filter(|line| !word(line).starts_with("file/com"))
        .copied()
        .collect();
    if !kept
        .iter()
        .any(|line| !line.is_empty() && !line.starts_with('!'))
    {
        return None;
    }
    // The first line of a command file names a dataset; left empty it names none.
    let mut text = String::from("\n");
    if !kept.iter().any(names_model) {
        text.push_str(&format!("file/model={model}\n"));
    }
    for line in &kept {
        if !line.is_empty() {
            text.push_str(line);
            text.push('\n');
        }
    }
    if kept
        .last()
        .is_none_or(|line| !word(line).starts_with("stop"))
    {
        text.push_str("stop\n");
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::recorded_commands;

    #[test]
    fn a_co_simulation_becomes_a_command_file() {
        let messages = "\n command: simulate/initial_conditions\n\n  Begin Simulation\n command: var/11, fun=1.5\n command: var/11, fun=1.6\n \
                        command: sim/dyn, end=0.01, dtout=0.01\n";
        let text = recorded_commands(messages, "plant").unwrap();
        assert_eq!(
            text,
            "\nfile/model=plant\nsimulate/initial_conditions\nvar/11, fun=1.5\nvar/11, fun=1.6\nsim/dyn, end=0.01, dtout=0.01\nstop\n"
        );
    }

    #[test]
    fn a_command_file_comes_back() {
        let messages = " command: FILE/COMMAND=a.acf\n command: \n command: file/model=a\n command: ! note\n command: INTEGRATOR/ &\n \
                        command: , HHT\n command: sim/stat\n command: STOP\nFinished -----\n";
        let text = recorded_commands(messages, "b").unwrap();
        assert_eq!(
            text,
            "\nfile/model=a\n! note\nINTEGRATOR/ &\n, HHT\nsim/stat\nSTOP\n"
        );
        assert_eq!(recorded_commands("nothing\n command: \n", "b"), None);
    }
}
