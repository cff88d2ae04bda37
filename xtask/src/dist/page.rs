//! The page for any file server, and the tool that has the page in it.

use std::fs;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::licences::LICENCES;
use crate::process::{self, announce};
use crate::{toolchain, web, workspace};

/// The folder that is unpacked.
const FOLDER: &str = "isostep";

/// The name of the archive.
pub fn archive_name() -> String {
    format!("isostep-{}-page.zip", env!("CARGO_PKG_VERSION"))
}

/// The name of the tool for a platform.
pub fn tool_name(target: &str) -> String {
    format!("isostep-{}-{target}{}", env!("CARGO_PKG_VERSION"), std::env::consts::EXE_SUFFIX)
}

/// Builds the page, into the folder where `cargo xtask web` has it.
pub fn build() -> Result<PathBuf> {
    let page = web::default_out();
    web::build(&page)?;
    Ok(page)
}

/// The page as an archive, with these licences instead of its own. Equal files make equal bytes: each has the same date.
pub fn archive(page: &Path, licences: &str) -> Result<Vec<u8>> {
    let mut files = web::files(page)?;
    files.sort();
    let options = SimpleFileOptions::DEFAULT.compression_method(CompressionMethod::Stored).unix_permissions(0o644);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for path in files {
        let name = path.strip_prefix(page)?.to_str().context("a file of the page has a name in Unicode")?;
        let content = if name == LICENCES { licences.into() } else { fs::read(&path)? };
        archive.start_file(format!("{FOLDER}/{}", name.replace('\\', "/")), options)?;
        archive.write_all(&content)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// Builds the tool for this platform with the page in it, and returns its path.
pub fn tool(page: &Path, target: &str) -> Result<PathBuf> {
    announce(&format!("isostep for {target}, with the page in it (some minutes)"));
    let mut tool = toolchain::cargo("build");
    tool.args(["--release", "--locked", "--package=isostep", "--bin=isostep", "--target", target]);
    tool.env("ISOSTEP_PAGE", page);
    // What is given away has no use for names of functions, which are most of its size.
    tool.env("CARGO_PROFILE_RELEASE_DEBUG", "false").env("CARGO_PROFILE_RELEASE_STRIP", "symbols");
    let flags = format!("CARGO_TARGET_{}_RUSTFLAGS", target.to_uppercase().replace('-', "_"));
    tool.env(flags, toolchain::short_paths());
    process::run(&mut tool)?;
    Ok(workspace::target_dir()
        .join(target)
        .join("release")
        .join("isostep")
        .with_extension(std::env::consts::EXE_EXTENSION))
}

/// The platform that this runs on, by the compiler's name for it.
pub fn host() -> Result<String> {
    let words =
        process::output(Command::new("rustc").current_dir(workspace::root()).arg("-vV"), "rustc comes with Rust")?;
    let host = words.lines().find_map(|line| line.strip_prefix("host: "));
    Ok(host.context("rustc does not name its platform")?.to_owned())
}

/// What the files of the page are for, in Markdown.
pub fn which(target: &str) -> String {
    format!(
        "# The page\n\n\
         Nothing has to be installed for it, neither Rust nor Node.js.\n\n\
         - `{}` is for any file server: unpack it there. The folder `{FOLDER}` in it is the page. A browser that has opened it\n\
         \x20 once by https opens it without the server too, and can install it. It operates a board by USB in Chrome and Edge.\n\
         - `{}` is the tool for this platform, with the page in it: `isostep web --open` serves it on this computer, and\n\
         \x20 `isostep web --port` lends it a board. Rename it to `isostep`; on Linux and macOS make it executable by `chmod +x`.\n",
        archive_name(),
        tool_name(target)
    )
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use zip::ZipArchive;

    use super::*;

    fn made(name: &str) -> PathBuf {
        let page = std::env::temp_dir().join(format!("isostep-archive-{name}-{}", std::process::id()));
        fs::create_dir_all(page.join("0123")).unwrap();
        for (file, content) in [("index.html", "page"), ("0123/main.js", "script"), (LICENCES, "its own")] {
            fs::write(page.join(file), content).unwrap();
        }
        page
    }

    #[test]
    fn an_archive_has_the_whole_page_in_a_folder_and_the_same_bytes_each_time() {
        let (page, later) = (made("one"), made("other"));
        let an_hour_ago = fs::metadata(&later).unwrap().modified().unwrap() - std::time::Duration::from_hours(1);
        fs::File::open(later.join("index.html")).unwrap().set_modified(an_hour_ago).unwrap();
        let bytes = archive(&page, "of all").unwrap();
        assert!(bytes == archive(&later, "of all").unwrap());
        let mut archive = ZipArchive::new(Cursor::new(bytes)).unwrap();
        let mut read = |name: &str| {
            let mut text = String::new();
            archive.by_name(name).unwrap().read_to_string(&mut text).unwrap();
            text
        };
        assert_eq!(read("isostep/index.html"), "page");
        assert_eq!(read("isostep/0123/main.js"), "script");
        assert_eq!(read("isostep/LICENCES.txt"), "of all");
        assert_eq!(archive.len(), 3);
        for folder in [page, later] {
            fs::remove_dir_all(folder).unwrap();
        }
    }

    #[test]
    fn what_is_made_for_people_without_a_toolchain_is_explained() {
        let target = host().unwrap();
        let words = which(&target);
        for name in [archive_name(), tool_name(&target)] {
            assert!(words.contains(&format!("- `{name}` is ")), "{name} is not in {words}");
        }
    }
}
