use std::path::{Path, PathBuf};

use clap::CommandFactory;
use clap_complete::env::Shells;

use admire_syntax::diagnostic::{Code, Diagnostic};

use super::shell::{Exit, Shell};
use super::{Cli, Outcome};

/// Install manual pages and completions for bash, zsh and fish.
///
/// The files are written below a prefix, where shells and `man` look for them: share/man/man1, share/bash-completion, share/zsh,
/// share/fish. Files of an earlier installation are replaced; no other file is touched.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire install\n  sudo admire install --prefix /usr/local\n  man admire-identify"
)]
pub(super) struct Arguments {
    /// Prefix of the installation; by default, `~/.local`.
    #[arg(long, value_name = "DIR")]
    prefix: Option<PathBuf>,
}

/// Shells, each with the path of its completion script below a prefix.
const COMPLETIONS: [(&str, &str); 3] = [
    ("bash", "share/bash-completion/completions/admire"),
    ("zsh", "share/zsh/site-functions/_admire"),
    ("fish", "share/fish/vendor_completions.d/admire.fish"),
];

/// Installs the manual pages and completions.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let home = || std::env::home_dir().map(|home| home.join(".local"));
    let Some(prefix) = arguments.prefix.clone().or_else(home) else {
        let message = "the home folder of the user is unknown";
        return Err(shell.usage(
            Diagnostic::error(Code::CannotWrite, message)
                .help("name the folder of the installation by --prefix DIR"),
        ));
    };
    let mut files = pages().map_err(|error| refused(&prefix, &error, shell))?;
    let shells = Shells::builtins();
    for (name, path) in COMPLETIONS {
        let completer = shells.completer(name).expect("a shell of the list");
        let mut text = Vec::new();
        completer
            .write_registration("COMPLETE", "admire", "admire", "admire", &mut text)
            .map_err(|error| refused(&prefix, &error, shell))?;
        files.push((path.to_string(), text));
    }
    let pages = files.len() - COMPLETIONS.len();
    for (path, bytes) in &files {
        let path = prefix.join(path);
        let folder = path.parent().unwrap_or(&prefix);
        std::fs::create_dir_all(folder).map_err(|error| refused(folder, &error, shell))?;
        shell.write(&path, bytes)?;
    }
    let mut text = format!(
        "{pages} manual pages below {}\n",
        prefix.join("share/man/man1").display()
    );
    for (name, path) in COMPLETIONS {
        text += &format!("completions of {name}: {}\n", prefix.join(path).display());
    }
    shell.print(&text);
    Ok(Exit::Fine)
}

fn refused(path: &Path, error: &std::io::Error, shell: &Shell) -> Exit {
    let message = format!("`{}` cannot be written: {error}", path.display());
    shell.fail(Diagnostic::error(Code::CannotWrite, message))
}

/// Creates the manual pages of `admire` and of each of its commands.
fn pages() -> std::io::Result<Vec<(String, Vec<u8>)>> {
    let mut command = Cli::command();
    command.build();
    let mut files = vec![page("admire", command.clone())?];
    for inner in command.get_subcommands() {
        if inner.get_name() != "help" {
            files.push(page(
                &format!("admire-{}", inner.get_name()),
                inner.clone(),
            )?);
        }
    }
    Ok(files)
}

fn page(name: &str, command: clap::Command) -> std::io::Result<(String, Vec<u8>)> {
    let mut text = Vec::new();
    clap_mangen::Man::new(command.display_name(name.to_string()))
        .title(name.to_uppercase())
        .render(&mut text)?;
    Ok((format!("share/man/man1/{name}.1"), text))
}
