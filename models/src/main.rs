//! The `pdlang` command.

mod command;

use std::process::ExitCode;

fn main() -> ExitCode {
    quiet_pipes();
    command::main()
}

/// Who closes a pipe (`pdlang models | head`) has read enough: no panic.
fn quiet_pipes() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let message = panic.payload().downcast_ref::<String>();
        if message.is_some_and(|m| m.starts_with("failed printing to std")) {
            std::process::exit(0);
        }
        usual(panic);
    }));
}
