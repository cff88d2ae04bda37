//! The files of the page, in memory.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

/// The files built into this tool, by `build.rs`.
const OWN: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/page.rs"));
const REMEDY: &str = "`cargo xtask web` makes one in target/web, and `cargo xtask web --install` a tool that has it";
/// The text before the policy in the page, which holds for its workers too if it comes as a header.
const POLICY: &str = "http-equiv=\"Content-Security-Policy\" content=\"";

/// Compressions of files, the smallest first: by the name in HTTP, and at the end of the file's name.
const ENCODINGS: [(&str, &str); 2] = [("br", "br"), ("gzip", "gz")];

/// A file as it is sent.
pub struct File<'a> {
    /// Its content, by `encoding`.
    pub content: &'a [u8],
    /// The media type of what is compressed.
    pub media_type: &'static str,
    /// Its compression.
    pub encoding: Option<&'static str>,
}

/// The page. Nothing else can be asked for, whatever is in a path.
pub struct Page {
    files: BTreeMap<String, Cow<'static, [u8]>>,
    policy: String,
}

impl Page {
    /// The page that is in this tool.
    ///
    /// # Errors
    /// When the tool was built without it.
    pub fn own() -> Result<Self> {
        ensure!(!OWN.is_empty(), "this tool was built without the page: name a folder by --page. {REMEDY}");
        Self::new(OWN.iter().map(|(name, content)| ((*name).to_owned(), Cow::Borrowed(*content))).collect())
    }

    /// The page in a folder, as it is now.
    ///
    /// # Errors
    /// When the folder has no page in it.
    pub fn read(folder: &Path) -> Result<Self> {
        let shown = folder.display();
        ensure!(folder.join("index.html").is_file(), "{shown} has no page in it, as there is no index.html. {REMEDY}");
        let mut files = BTreeMap::new();
        add(&mut files, folder, "").with_context(|| format!("{shown} cannot be read"))?;
        Self::new(files)
    }

    fn new(files: BTreeMap<String, Cow<'static, [u8]>>) -> Result<Self> {
        let index = files.get("index.html").map(|index| String::from_utf8_lossy(index)).unwrap_or_default();
        let policy = index.split_once(POLICY).and_then(|(_, rest)| rest.split_once('"')).map(|(policy, _)| policy);
        let policy =
            policy.with_context(|| format!("the page's index.html has no policy, so it is another's. {REMEDY}"))?;
        let policy = format!("{policy}; frame-ancestors 'none'");
        Ok(Self { files, policy })
    }

    /// The page's own policy; and nobody may put it into a frame, which only a header can say.
    pub fn policy(&self) -> &str {
        &self.policy
    }

    /// The file of a path, compressed in a way that is accepted, if it is there.
    pub fn file(&self, path: &str, accepted: &str) -> Option<File<'_>> {
        let name = path.strip_prefix('/').map(|name| if name.is_empty() { "index.html" } else { name })?;
        let accepts = |encoding: &str| accepted.split([',', ';']).any(|word| word.trim() == encoding);
        let compressed =
            ENCODINGS.into_iter().filter(|&(encoding, _)| accepts(encoding)).find_map(|(encoding, end)| {
                self.files.get(&format!("{name}.{end}")).map(|content| (content, Some(encoding)))
            });
        let (content, encoding) = compressed.or_else(|| self.files.get(name).map(|content| (content, None)))?;
        Some(File { content, media_type: media_type(name), encoding })
    }
}

fn add(files: &mut BTreeMap<String, Cow<'static, [u8]>>, folder: &Path, before: &str) -> Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = format!("{before}{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            add(files, &entry.path(), &format!("{name}/"))?;
        } else {
            files.insert(name, fs::read(entry.path())?.into());
        }
    }
    Ok(())
}

fn media_type(name: &str) -> &'static str {
    match name.rsplit('.').next().unwrap_or_default() {
        "html" => "text/html; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "json" => "application/json",
        "webmanifest" => "application/manifest+json",
        "wasm" => "application/wasm",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "nc" | "txt" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}
