//! The files named by a verb's options. They are checked together before the verb runs: no file may overwrite another,
//! and each must be writable where it is written, because otherwise the result of a long run would be lost.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use isostep_report::pictures::document::Page;

use crate::project;

/// The files that the options of a verb name.
#[derive(Default)]
pub struct Files(Vec<Named>);

struct Named {
    option: &'static str,
    path: PathBuf,
    role: Role,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    /// Read, never written.
    Read,
    Written,
    /// A symbolic link. It counts as a file of its own, separate from the file it points to.
    Link,
    /// A folder that a page and its pictures are written into.
    Page,
}

impl Files {
    /// Adds files that are read.
    pub fn read<'p>(self, option: &'static str, paths: impl IntoIterator<Item = &'p PathBuf>) -> Self {
        self.with(Role::Read, option, paths)
    }

    /// Adds files that are written.
    pub fn written<'p>(self, option: &'static str, paths: impl IntoIterator<Item = &'p PathBuf>) -> Self {
        self.with(Role::Written, option, paths)
    }

    /// Adds symbolic links that are created.
    pub fn link<'p>(self, option: &'static str, paths: impl IntoIterator<Item = &'p PathBuf>) -> Self {
        self.with(Role::Link, option, paths)
    }

    /// Adds folders that a page and its pictures are written into.
    pub fn page<'p>(self, option: &'static str, paths: impl IntoIterator<Item = &'p PathBuf>) -> Self {
        self.with(Role::Page, option, paths)
    }

    fn with<'p>(mut self, role: Role, option: &'static str, paths: impl IntoIterator<Item = &'p PathBuf>) -> Self {
        self.0.extend(paths.into_iter().map(|path| Named { option, path: path.clone(), role }));
        self
    }

    /// # Errors
    /// When one file would overwrite another, or when a file cannot be written because its folder does not exist.
    pub fn check(&self) -> Result<()> {
        for (index, one) in self.0.iter().enumerate() {
            one.check()?;
            for other in &self.0[..index] {
                apart(other, one)?;
            }
        }
        Ok(())
    }
}

impl Named {
    fn words(&self) -> String {
        format!("{} {}", self.option, self.path.display())
    }

    fn check(&self) -> Result<()> {
        let words = self.words();
        match self.role {
            Role::Read => {}
            Role::Page => ensure!(
                !self.path.exists() || self.path.is_dir(),
                "{words}: this is a file, and pages go into a folder: name another"
            ),
            Role::Written | Role::Link => {
                ensure!(!self.path.is_dir(), "{words}: this is a folder: name a file in it");
                let folder = folder(&self.path);
                ensure!(folder.is_dir(), "{words}: there is no folder {}: make it first", folder.display());
            }
        }
        Ok(())
    }

    /// The canonical path, with links followed. For a file that does not exist yet, the canonical path of its folder
    /// and its name.
    fn place(&self) -> PathBuf {
        let there = fs::canonicalize(&self.path).ok().filter(|_| self.role != Role::Link);
        there.unwrap_or_else(|| {
            let folder = folder(&self.path);
            let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
            self.path.file_name().map_or(folder.clone(), |name| folder.join(name))
        })
    }

    /// This is a page that may write `other`: its `index.html` or one of its pictures.
    fn covers(&self, other: &Self) -> bool {
        let place = other.place();
        let name = place.file_name().unwrap_or_default();
        let is_of_page =
            name == "index.html" || ["svg", "png"].iter().any(|of| Path::new(name).extension() == Some(of.as_ref()));
        self.role == Role::Page && is_of_page && place.parent() == Some(&self.place())
    }

    fn is(&self, other: &Self) -> bool {
        let of_link = self.role == Role::Link || other.role == Role::Link;
        self.place() == other.place() || !of_link && is_hard_link(&self.path, &other.path)
    }
}

/// Refuses two options that would overwrite each other. The same file may be read twice, and a device or a pipe has no
/// contents that could be lost.
fn apart(one: &Named, other: &Named) -> Result<()> {
    if one.role == Role::Read && other.role == Role::Read {
        return Ok(());
    }
    let (words, others) = (one.words(), other.words());
    if one.covers(other) || other.covers(one) {
        bail!(
            "{words} and {others}: a page writes index.html and its pictures (.svg, .png) into its folder: choose another name"
        );
    }
    if !one.is(other) || is_stream(&one.path) {
        return Ok(());
    }
    match (one.role, other.role) {
        (Role::Read, _) => bail!("{others} would be written over {words}, which is read: choose another name"),
        (_, Role::Read) => bail!("{words} would be written over {others}, which is read: choose another name"),
        _ => {
            bail!("{words} and {others} are the same file, and one would be written over the other: give each its own")
        }
    }
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|there| !there.is_file() && !there.is_dir())
}

#[cfg(unix)]
fn is_hard_link(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;

    let id =
        |path: &Path| fs::metadata(path).ok().filter(fs::Metadata::is_file).map(|there| (there.dev(), there.ino()));
    id(one).is_some_and(|one| id(other) == Some(one))
}

#[cfg(not(unix))]
fn is_hard_link(_one: &Path, _other: &Path) -> bool {
    false
}

/// Writes a file and says so on the screen.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_by(path, |out| out.write_all(bytes))
}

/// The same piece by piece.
///
/// # Errors
/// A file that cannot be written.
pub fn write_by(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<()> {
    let cannot = || format!("{} cannot be written", path.display());
    let mut out = BufWriter::new(File::create(path).with_context(cannot)?);
    write(&mut out).with_context(cannot)?;
    out.flush().with_context(cannot)?;
    println!("wrote {}", project::shown(path));
    Ok(())
}

/// Writes a page and its pictures into a folder, which is made if it does not exist.
///
/// # Errors
/// A folder that cannot be made, or a file that cannot be written.
pub fn write_page(folder: &Path, page: &Page) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    page.files().iter().try_for_each(|(name, bytes)| write(&folder.join(name), bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder for this test alone, with a program in it.
    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("isostep-files-{name}-{}", std::process::id()));
        fs::create_dir_all(folder.join("report")).unwrap();
        fs::write(folder.join("my.nc"), "G0 X1\n").unwrap();
        folder
    }

    fn refused(files: Files) -> String {
        files.check().unwrap_err().to_string()
    }

    #[test]
    fn two_options_do_not_write_one_file() {
        let folder = folder("two");
        let (a, again) = (folder.join("a"), folder.join("report/../a"));
        let two = |a: &PathBuf, b: &PathBuf| Files::default().written("--trace", [a]).written("--json", [b]);
        let reported = refused(two(&a, &again));
        let names = format!("--trace {} and --json {} are the same file", a.display(), again.display());
        assert!(reported.starts_with(&names), "{reported}");
        fs::write(&a, "there").unwrap();
        assert!(refused(two(&a, &again)).starts_with(&names));
        two(&a, &folder.join("b")).check().unwrap();
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&a, folder.join("soft")).unwrap();
            fs::hard_link(&a, folder.join("hard")).unwrap();
            assert!(refused(two(&a, &folder.join("soft"))).contains("the same file"));
            assert!(refused(two(&a, &folder.join("hard"))).contains("the same file"));
            two(&"/dev/null".into(), &"/dev/null".into()).check().unwrap();
        }
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn nothing_that_is_read_is_written() {
        let folder = folder("read");
        let my = folder.join("my.nc");
        let reported = refused(Files::default().read("FILE.nc", [&my]).written("--json", [&my]));
        assert!(reported.contains("--json ") && reported.contains("would be written over FILE.nc "), "{reported}");
        let reported = refused(Files::default().written("--flash", [&my]).read("--settings", [&my]));
        assert!(
            reported.starts_with("--flash ") && reported.contains("would be written over --settings "),
            "{reported}"
        );
        Files::default().read("FILE.nc", [&my]).read("--settings", [&my]).check().unwrap();
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_page_keeps_its_files() {
        let folder = folder("page");
        let report = folder.join("report");
        let beside = |name: &str| Files::default().page("--report", [&report]).written("--json", [&report.join(name)]);
        beside("figures.json").check().unwrap();
        assert!(refused(beside("index.html")).contains("choose another name"));
        assert!(refused(beside("move-5.svg")).contains("choose another name"));
        let same = Files::default().page("--report", [&folder.join("new")]).written("--json", [&folder.join("new")]);
        assert!(refused(same).contains("the same file"));
        let onto = Files::default().page("--report", [&folder.join("my.nc")]);
        assert!(refused(onto).contains("this is a file"));
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_cannot_be_written_is_reported_beforehand() {
        let folder = folder("cannot");
        let reported = refused(Files::default().written("--trace", [&folder.join("no/a.csv")]));
        assert!(reported.ends_with("/no: make it first"), "{reported}");
        assert!(
            refused(Files::default().written("--trace", [&folder])).ends_with("this is a folder: name a file in it")
        );
        Files::default().written("--trace", [&"a.csv".into()]).check().unwrap();
        fs::remove_dir_all(folder).unwrap();
    }

    /// A killed run can leave a link that points to a terminal. The link is replaced; the terminal is not written to.
    #[cfg(unix)]
    #[test]
    fn a_link_is_itself() {
        let folder = folder("link");
        let link = folder.join("port");
        std::os::unix::fs::symlink(folder.join("my.nc"), &link).unwrap();
        let with = |trace: &PathBuf| Files::default().link("--link", [&link]).written("--trace", [trace]);
        with(&folder.join("my.nc")).check().unwrap();
        fs::remove_file(&link).unwrap();
        assert!(refused(with(&link)).contains("the same file"));
        fs::remove_dir_all(folder).unwrap();
    }
}
