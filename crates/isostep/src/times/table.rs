//! The table of Grbl's times.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

use crate::project;

const PROGRAM: &str = "program";
const MAX_FEED: &str = "_max_feed_s";
const OWN_FEED: &str = "_s";

/// The format is described in `isostep times --help`.
#[derive(Debug, PartialEq)]
pub struct Table {
    pub columns: Vec<Column>,
    pub rows: Vec<Row>,
}

/// The times on one machine.
#[derive(Debug, PartialEq)]
pub struct Column {
    /// The name in the table, without its unit.
    pub name: String,
    pub machine: String,
    /// Every feed is replaced by F12000.
    pub is_max_feed: bool,
}

/// The times of a program.
#[derive(Debug, PartialEq)]
pub struct Row {
    pub program: String,
    /// One time per column, in order; `None` where the table has none.
    pub grbl_s: Vec<Option<f64>>,
}

impl Table {
    /// Reads the table from a file.
    pub fn read(path: &Path) -> Result<Self> {
        let name = project::shown(path);
        let text = std::fs::read_to_string(path).with_context(|| format!("{name} cannot be read"))?;
        Self::parse(&text).with_context(|| name)
    }

    fn parse(text: &str) -> Result<Self> {
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let header = reader.headers()?.clone();
        let program = header.iter().position(|name| name == PROGRAM);
        let program =
            program.with_context(|| format!("it has no column `{PROGRAM}`: name the programs' files in one"))?;
        let columns: Vec<_> =
            header.iter().enumerate().filter_map(|(at, name)| Some((at, Column::of(name)?))).collect();
        ensure!(
            !columns.is_empty(),
            "it has no column of times: name one for each machine, such as A_s or A_max_feed_s"
        );
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record?;
            let line = record.position().map_or(0, csv::Position::line);
            let times = columns.iter().map(|(at, _)| seconds(line, &header[*at], &record[*at]));
            rows.push(Row { program: record[program].to_owned(), grbl_s: times.collect::<Result<_>>()? });
        }
        ensure!(!rows.is_empty(), "it has no row: give one for each program");
        Ok(Self { columns: columns.into_iter().map(|(_, column)| column).collect(), rows })
    }

    /// The rows of these programs; all rows if none is named.
    pub fn only(mut self, programs: &[String]) -> Result<Self> {
        if let Some(unknown) = programs.iter().find(|&name| self.rows.iter().all(|row| row.program != *name)) {
            let known: Vec<_> = self.rows.iter().map(|row| row.program.as_str()).collect();
            bail!("--only {unknown}: the table has no such program; it has {}", known.join(", "));
        }
        self.rows.retain(|row| programs.is_empty() || programs.contains(&row.program));
        Ok(self)
    }

    /// The names of the machines without repetition.
    pub fn machines(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for column in &self.columns {
            if !names.contains(&column.machine) {
                names.push(column.machine.clone());
            }
        }
        names
    }
}

impl Column {
    fn of(header: &str) -> Option<Self> {
        let (machine, is_max_feed) = match header.strip_suffix(MAX_FEED) {
            Some(machine) => (machine, true),
            None => (header.strip_suffix(OWN_FEED)?, false),
        };
        let name = header.strip_suffix(OWN_FEED)?.to_owned();
        (!machine.is_empty()).then(|| Self { name, machine: machine.to_owned(), is_max_feed })
    }
}

fn seconds(line: u64, column: &str, field: &str) -> Result<Option<f64>> {
    if field.is_empty() {
        return Ok(None);
    }
    let seconds = field.parse().ok().filter(|seconds: &f64| *seconds > 0.0 && seconds.is_finite());
    Ok(Some(
        seconds
            .with_context(|| format!("line {line}: {column} is `{field}`: give seconds above 0, or leave it empty"))?,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        format!("{:#}", Table::parse(text).unwrap_err())
    }

    #[test]
    fn columns_are_machines_and_what_else_there_is_is_passed_over() {
        let table = Table::parse("program,moves,A_s,mm,B_max_feed_s\na.nc,3,1.5,2,\nb.nc,4, 2 ,2,7\n").unwrap();
        let names: Vec<_> =
            table.columns.iter().map(|one| (one.name.as_str(), one.machine.as_str(), one.is_max_feed)).collect();
        assert_eq!(names, [("A", "A", false), ("B_max_feed", "B", true)]);
        assert_eq!(table.rows[0], Row { program: "a.nc".to_owned(), grbl_s: vec![Some(1.5), None] });
        assert_eq!(table.rows[1].grbl_s, [Some(2.0), Some(7.0)]);
        assert_eq!(table.machines(), ["A", "B"]);
        let unknown = format!("{:#}", table.only(&["c.nc".to_owned()]).unwrap_err());
        assert!(unknown.contains("it has a.nc, b.nc"), "{unknown}");
    }

    #[test]
    fn what_is_no_table_is_refused_with_what_to_do() {
        assert!(refusal("name,A_s\nx,1\n").contains("no column `program`"));
        assert!(refusal("program,moves\nx,1\n").contains("such as A_s"));
        assert!(refusal("program,A_s\n").contains("one for each program"));
        assert!(refusal("program,A_s\nx,1\ny,-3\n").contains("line 3: A_s is `-3`: give seconds above 0"));
        assert!(refusal("program,A_s\nx\n").contains("fields"));
    }
}
