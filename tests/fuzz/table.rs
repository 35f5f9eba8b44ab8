//! Logs as columns, and what goes wrong between a robot and a file of them.

use super::dice::Dice;
use super::tokens;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub header: Vec<String>,
    /// The first is time (s).
    pub columns: Vec<Vec<f64>>,
    style: Style,
    /// Cells and lines that are not what they should be: row, and what stands there.
    odd: Vec<(usize, Odd)>,
}

#[derive(Debug, Clone, PartialEq)]
enum Odd {
    Cell(usize, String),
    Line(String),
    /// So many cells are missing at the end.
    Short(usize),
    Longer,
}

#[derive(Debug, Clone, PartialEq)]
struct Style {
    delimiter: &'static str,
    decimal_comma: bool,
    line_end: &'static str,
    digits: Option<usize>,
    header: bool,
    encoding: Encoding,
    before: &'static str,
    gzip: Gzip,
    /// Bytes that are missing at the end.
    cut: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Encoding {
    Utf8,
    Utf8Mark,
    Utf16,
    Latin1,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Gzip {
    Plain,
    Whole,
    Members,
    Cut,
    Spoiled,
}

impl Table {
    pub fn new(header: Vec<String>, columns: Vec<Vec<f64>>) -> Self {
        let style = Style {
            delimiter: ",",
            decimal_comma: false,
            line_end: "\n",
            digits: Some(7),
            header: true,
            encoding: Encoding::Utf8,
            before: "",
            gzip: Gzip::Plain,
            cut: 0,
        };
        Self {
            header,
            columns,
            style,
            odd: Vec::new(),
        }
    }

    pub fn rows(&self) -> usize {
        self.columns.iter().map(Vec::len).min().unwrap_or(0)
    }

    pub fn render(&self) -> Vec<u8> {
        let style = &self.style;
        let mut text = style.before.to_string();
        if style.header {
            text.push_str(&self.header.join(style.delimiter));
            text.push_str(style.line_end);
        }
        for row in 0..self.rows() {
            text.push_str(&self.line(row));
            text.push_str(style.line_end);
        }
        let mut bytes = encoded(&text, style.encoding);
        bytes.truncate(bytes.len().saturating_sub(style.cut));
        packed(&bytes, style.gzip)
    }

    fn line(&self, row: usize) -> String {
        let number = |value: f64| {
            let text = match self.style.digits {
                Some(digits) if value.abs() < 1e15 && (value == 0.0 || value.abs() > 1e-6) => format!("{value:.digits$}"),
                _ => tokens::shortest(value),
            };
            if self.style.decimal_comma {
                text.replace('.', ",")
            } else {
                text
            }
        };
        let mut cells: Vec<String> = self.columns.iter().map(|column| number(column[row])).collect();
        for (_, odd) in self.odd.iter().filter(|(at, _)| *at == row) {
            match odd {
                Odd::Cell(column, text) if *column < cells.len() => cells[*column].clone_from(text),
                Odd::Line(text) => return text.clone(),
                Odd::Short(count) => cells.truncate(cells.len().saturating_sub(*count)),
                _ => cells.push("1".into()),
            }
        }
        cells.join(self.style.delimiter)
    }

    /// Changes one thing.
    pub fn mutate(&mut self, dice: &mut Dice) {
        match dice.below(20) {
            0..=8 => self.change_column(dice),
            9..=12 => self.change_time(dice),
            13..=14 => self.change_rows(dice),
            15 => self.change_columns(dice),
            16 | 17 => self.change_style(dice),
            _ => self.change_text(dice),
        }
    }

    /// Values of one column, or of all columns of its kind.
    fn change_column(&mut self, dice: &mut Dice) {
        if self.columns.len() < 2 {
            return;
        }
        let at = 1 + dice.below(self.columns.len() - 1);
        let half = self.columns.len() / 2;
        let all = match dice.below(4) {
            0 => 1..self.columns.len(),
            1 if at > half => half + 1..self.columns.len(),
            1 => 1..half + 1,
            _ => at..at + 1,
        };
        let (kind, run_seed) = (dice.below(17), dice.bits());
        let value = tokens::number(dice).parse().unwrap_or(1.0);
        let exponent = [150.0, -150.0, 300.0, -300.0, 12.0, -12.0, 3.0, -3.0][dice.below(8)];
        for column in all {
            let first = self.columns[column].first().copied().unwrap_or(0.0);
            let source = 1 + Dice::new(run_seed).below(self.columns.len() - 1);
            let source = self.columns[source].clone();
            let values = &mut self.columns[column];
            let run = Dice::new(run_seed).run(values.len(), values.len());
            match kind {
                0 => values.fill(0.0),
                1 => values.fill(first),
                2 => values.fill(f64::NAN),
                3 => values.fill(value),
                4 | 5 => values.iter_mut().for_each(|v| *v *= 10f64.powf(exponent)),
                6 => values.iter_mut().for_each(|v| *v = -*v),
                7 => values.iter_mut().for_each(|v| *v = v.to_degrees()),
                8 => *values = source,
                9 => values[run].fill(f64::NAN),
                10 => values[run.clone()].fill(source.get(run.start).copied().unwrap_or(0.0)),
                11 => values[run.start.min(run.end)..run.end]
                    .iter_mut()
                    .take(1)
                    .for_each(|v| *v = value),
                12 => {
                    // A column that begins without a number has no bound.
                    let most = if first.is_nan() { f64::INFINITY } else { 0.3 * first.abs() };
                    values.iter_mut().for_each(|v| *v = v.clamp(-most, most));
                }
                13 => values.iter_mut().for_each(|v| *v = (*v * 10.0).round() / 10.0),
                14 => {
                    let mut noise = Dice::new(run_seed);
                    values.iter_mut().for_each(|v| *v = noise.between(-1.0, 1.0));
                }
                15 => values.reverse(),
                _ => values.iter_mut().for_each(|v| *v += value),
            }
        }
    }

    fn change_time(&mut self, dice: &mut Dice) {
        let Some(time) = self.columns.first_mut().filter(|t| !t.is_empty()) else {
            return;
        };
        let at = dice.below(time.len());
        let value: f64 = tokens::number(dice).parse().unwrap_or(1.0);
        let mut jitter = Dice::new(dice.bits());
        match dice.below(15) {
            0 => time[at] = value,
            1 => *time.last_mut().expect("is not empty") = 1e12,
            2 => time.iter_mut().for_each(|t| *t += 1_764_315_000.0),
            3 => time.iter_mut().for_each(|t| *t = 1.764315e18 + *t * 1e9),
            4 => time.iter_mut().for_each(|t| *t *= 1e3),
            5 => time.fill(value),
            6 => time.reverse(),
            7 => time[at..].iter_mut().for_each(|t| *t += value),
            8 => time[at] = time[at.saturating_sub(1)],
            9 => time[at] = f64::NAN,
            10 => time.iter_mut().for_each(|t| *t += jitter.between(-0.02, 0.02)),
            11 => time.iter_mut().for_each(|t| *t *= value),
            12 => time.fill(f64::NAN),
            13 => time.iter_mut().for_each(|t| *t = (*t * 10.0).round() / 10.0),
            _ => time.iter_mut().for_each(|t| *t *= 10f64.powf(jitter.between(-6.0, 6.0))),
        }
    }

    fn change_rows(&mut self, dice: &mut Dice) {
        let rows = self.rows();
        let run = dice.run(rows, rows.max(1));
        match dice.below(4) {
            0 => {
                let keep = [0, 1, 2, 3, 4, 5, 7, 10, 13, 20, 40, 100][dice.below(12)];
                self.columns.iter_mut().for_each(|c| c.truncate(keep));
            }
            1 => self.columns.iter_mut().for_each(|c| drop(c.drain(run.clone()))),
            2 => self.columns.iter_mut().for_each(|c| c.extend_from_within(run.clone())),
            _ => self.columns.iter_mut().for_each(|c| c[run.clone()].reverse()),
        }
    }

    fn change_columns(&mut self, dice: &mut Dice) {
        let count = self.columns.len();
        let (at, other) = (dice.below(count), dice.below(count));
        match dice.below(5) {
            0 if count > 0 => {
                self.columns.remove(at);
                self.header.remove(at.min(self.header.len().saturating_sub(1)));
            }
            1 if count > 0 => self.columns.swap(at, other),
            2 if count > 0 => {
                self.columns.push(self.columns[at].clone());
                self.header.push(tokens::word(dice));
            }
            3 if !self.header.is_empty() => {
                let at = dice.below(self.header.len());
                self.header[at] = match dice.below(3) {
                    0 => self.header[0].clone(),
                    1 => dice
                        .pick(&["q1", "tau2", "qd1", "position_1", "effort[0]", "TIME", "t", "current1"])
                        .to_string(),
                    _ => tokens::word(dice),
                };
            }
            _ => self.header.reverse(),
        }
    }

    fn change_style(&mut self, dice: &mut Dice) {
        let style = &mut self.style;
        match dice.below(8) {
            0 => style.delimiter = dice.pick(&[";", "\t", " ", "|", "  ", ", ", "\u{1}"]),
            1 => (style.decimal_comma, style.delimiter) = (true, dice.pick(&[";", "\t", ","])),
            2 => style.line_end = dice.pick(&["\r\n", "\r", "\n\n", "\n\r", ""]),
            3 => style.digits = [None, Some(0), Some(1), Some(3), Some(17), Some(40)][dice.below(6)],
            4 => style.header = false,
            5 => style.encoding = [Encoding::Utf8Mark, Encoding::Utf16, Encoding::Latin1][dice.below(3)],
            6 => style.before = dice.pick(&["# a comment\n", "\n\n", "sep=;\n", "// x\n", "a title\n", "%\n", "\"", "\0"]),
            _ => style.gzip = [Gzip::Whole, Gzip::Members, Gzip::Cut, Gzip::Spoiled][dice.below(4)],
        }
        if dice.chance(0.1) {
            style.cut = 1 + dice.below(60);
        }
    }

    fn change_text(&mut self, dice: &mut Dice) {
        for _ in 0..1 + dice.below(4) * dice.below(20) {
            let row = dice.below(self.rows());
            let odd = match dice.below(6) {
                0 => Odd::Line(
                    dice.pick(&[
                        "",
                        "# comment",
                        "garbage",
                        ",,,,",
                        "\"",
                        "time,q1,q2,tau1,tau2",
                        "\0\0\0",
                        "1",
                    ])
                    .to_string(),
                ),
                1 => Odd::Short(1 + dice.below(4)),
                2 => Odd::Longer,
                3 => Odd::Cell(dice.below(self.columns.len()), tokens::no_number(dice)),
                4 => Odd::Cell(dice.below(self.columns.len()), tokens::word(dice)),
                _ => Odd::Cell(dice.below(self.columns.len()), tokens::number(dice)),
            };
            self.odd.push((row, odd));
        }
    }
}

fn encoded(text: &str, encoding: Encoding) -> Vec<u8> {
    match encoding {
        Encoding::Utf8 => text.as_bytes().to_vec(),
        Encoding::Utf8Mark => [b"\xef\xbb\xbf", text.as_bytes()].concat(),
        Encoding::Utf16 => std::iter::once(0xfeff)
            .chain(text.encode_utf16())
            .flat_map(u16::to_le_bytes)
            .collect(),
        Encoding::Latin1 => text.chars().map(|c| u8::try_from(u32::from(c)).unwrap_or(0xe9)).collect(),
    }
}

fn packed(bytes: &[u8], gzip: Gzip) -> Vec<u8> {
    let pack = |part: &[u8]| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(part).expect("memory takes all");
        encoder.finish().expect("memory takes all")
    };
    let half = bytes.len() / 2;
    match gzip {
        Gzip::Plain => bytes.to_vec(),
        Gzip::Whole => pack(bytes),
        Gzip::Members => [pack(&bytes[..half]), pack(&bytes[half..])].concat(),
        Gzip::Cut => {
            let mut all = pack(bytes);
            all.truncate(all.len() * 2 / 3);
            all
        }
        Gzip::Spoiled => {
            let mut all = pack(bytes);
            let middle = all.len() / 2;
            all[middle] ^= 0x55;
            all
        }
    }
}
