//! The words of a panic. It is a defect, and ends the machine; the page lives, and reports it.

use std::cell::RefCell;
use std::panic;

use wasm_bindgen::prelude::wasm_bindgen;

thread_local! {
    static LAST: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Keeps the words of panics from now on.
#[wasm_bindgen(start)]
pub fn listen() {
    panic::set_hook(Box::new(|said| LAST.set(Some(said.to_string()))));
}

/// Panics, as a defect would, to try what the page says then.
#[wasm_bindgen(js_name = panicOnPurpose)]
pub fn panic_on_purpose() {
    panic!("on purpose");
}

/// The words of the last panic, with its place.
#[wasm_bindgen(js_name = lastPanic)]
pub fn last_panic() -> Option<String> {
    LAST.take()
}
