//! `isostep-bindgen MODULE.wasm FOLDER`: writes `machine.js`, its types and the module that it loads into a folder.

use std::env;

use anyhow::{Context, Result};
use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<()> {
    let mut arguments = env::args_os().skip(1);
    let [module, folder] = [(); 2].map(|()| arguments.next());
    let (module, folder) = module.zip(folder).context("say which module, and into which folder")?;
    Bindgen::new()
        .input_path(&module)
        .web(true)?
        .typescript(true)
        .out_name("machine")
        // The page shows the words of a panic and its place, and no names of functions.
        .remove_name_section(true)
        .remove_producers_section(true)
        .generate(&folder)
        .with_context(|| format!("{} gives no JavaScript", module.display()))
}
