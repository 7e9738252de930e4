//! The settings there are: what each is called, what it means, and which values it takes. Their names are those of the
//! command line.

use crate::colours::When;
use crate::logs::Level;
use crate::words::Size;
use clap::ValueEnum;

/// A setting.
#[derive(Debug)]
pub struct Setting {
    /// Its name in a grimace.ron and, with `-` for `_`, on the command line.
    pub name: &'static str,
    /// The variable of the environment that sets it.
    pub variable: &'static str,
    /// What it is where nothing sets it.
    pub default: &'static str,
    /// Whether it names a file or folder; a relative one starts from the folder of the file that names it.
    pub is_path: bool,
    /// Says what is expected, where a text is no value of it.
    pub check: fn(&str) -> Result<(), String>,
}

/// All settings.
pub const SETTINGS: [Setting; 6] = [
    Setting {
        name: "store",
        variable: "GRIMACE_STORE",
        default: ".grimace beside the graph",
        is_path: true,
        check: |_| Ok(()),
    },
    Setting {
        name: "jobs",
        variable: "GRIMACE_JOBS",
        default: "one for each core",
        is_path: false,
        check: |text| match text.parse::<u16>() {
            Ok(1..) => Ok(()),
            _ => Err("a whole number from 1 to 65535".to_owned()),
        },
    },
    Setting {
        name: "memory",
        variable: "GRIMACE_MEMORY",
        default: "four fifths of what there is",
        is_path: false,
        check: |text| match text.parse() {
            Ok(Size(1..)) => Ok(()),
            _ => Err("a size such as 16GB".to_owned()),
        },
    },
    Setting { name: "color", variable: "GRIMACE_COLOR", default: "auto", is_path: false, check: one_of::<When> },
    Setting { name: "log", variable: "GRIMACE_LOG", default: "off", is_path: false, check: one_of::<Level> },
    Setting {
        name: "log_file",
        variable: "GRIMACE_LOG_FILE",
        default: "standard error",
        is_path: true,
        check: |_| Ok(()),
    },
];

/// Variables that begin like settings and are none.
pub const OTHER_VARIABLES: [&str; 2] = ["GRIMACE_PLUGINS", "GRIMACE_TEST_DATA"];

fn one_of<T: ValueEnum>(text: &str) -> Result<(), String> {
    if T::from_str(text, false).is_ok() {
        return Ok(());
    }
    let names = T::value_variants().iter().filter_map(T::to_possible_value);
    let names: Vec<String> = names.map(|value| format!("`{}`", value.get_name())).collect();
    Err(format!("one of {}", names.join(", ")))
}
