//! Reads and writes points in PLY: text, little-endian and big-endian.

use super::unreadable;
use crate::support::file_error::FaultText;
use crate::support::regular_file;
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::ops::Range;
use std::path::Path;

/// Vertices of a PLY file as stored. Other elements (faces, edges) are left out, because they refer
/// to vertices that may be removed.
#[derive(Debug)]
pub(super) struct PlyFile {
    /// Header lines between `ply` and `end_header` about the vertices, without their count.
    header: Vec<String>,
    bytes: Vec<u8>,
    /// Range of each vertex in the bytes.
    vertices: Vec<Range<usize>>,
}

/// Encoding of numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum PlyEncoding {
    #[default]
    Text,
    Little,
    Big,
}

/// A scalar type, with its number of bytes.
#[derive(Clone, Copy, Debug)]
enum Scalar {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Scalar::Signed(1),
            "short" | "int16" => Scalar::Signed(2),
            "int" | "int32" => Scalar::Signed(4),
            "uchar" | "uint8" => Scalar::Unsigned(1),
            "ushort" | "uint16" => Scalar::Unsigned(2),
            "uint" | "uint32" => Scalar::Unsigned(4),
            "float" | "float32" => Scalar::Float(4),
            "double" | "float64" => Scalar::Float(8),
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Scalar::Signed(size) | Scalar::Unsigned(size) | Scalar::Float(size) => size,
        }
    }

    /// Returns the value of the stored bytes of one number.
    fn value(self, stored: &[u8], encoding: PlyEncoding) -> f64 {
        let mut little = [0_u8; 8];
        for (to, &from) in little.iter_mut().zip(stored) {
            *to = from;
        }
        if encoding == PlyEncoding::Big {
            little[..self.size()].reverse();
        }
        let bits = u64::from_le_bytes(little);
        let unused = 64 - 8 * self.size() as u32;
        match self {
            Scalar::Unsigned(_) => bits as f64,
            Scalar::Signed(_) => ((bits << unused) as i64 >> unused) as f64,
            Scalar::Float(4) => f64::from(f32::from_bits(bits as u32)),
            Scalar::Float(_) => f64::from_bits(bits),
        }
    }
}

/// Content of a PLY header.
#[derive(Default)]
struct PlyLayout {
    encoding: PlyEncoding,
    count: usize,
    properties: Vec<(String, Scalar)>,
    kept_lines: Vec<String>,
    /// Offset of the data after the header.
    data: usize,
    lines: usize,
}

/// Reads the vertices; they must be the first element and have only scalar properties.
pub(super) fn read(path: &Path) -> Result<(PlyFile, Vec<[f64; 3]>), FaultText> {
    let bytes = regular_file::read(path, u64::MAX).map_err(|error| unreadable(&error))?;
    let layout = PlyLayout::parse(&bytes)?;
    let axes =
        ["x", "y", "z"].map(|axis| layout.properties.iter().position(|(name, _)| name == axis));
    let [Some(x), Some(y), Some(z)] = axes else {
        return Err("the PLY header names no vertex properties x, y and z".into());
    };
    let (vertices, points) = match layout.encoding {
        PlyEncoding::Text => read_text(&bytes, &layout, [x, y, z])?,
        _ => read_binary(&bytes, &layout, [x, y, z])?,
    };
    let header = layout.kept_lines;
    Ok((PlyFile { header, bytes, vertices }, points))
}

type Vertices = (Vec<Range<usize>>, Vec<[f64; 3]>);

fn read_binary(bytes: &[u8], layout: &PlyLayout, axes: [usize; 3]) -> Result<Vertices, String> {
    let size: usize = layout.properties.iter().map(|(_, scalar)| scalar.size()).sum();
    let whole = (bytes.len() - layout.data) / size;
    if whole < layout.count {
        return Err(too_short(whole, layout.count));
    }
    let fields = axes.map(|axis| {
        let before = layout.properties[..axis].iter().map(|(_, scalar)| scalar.size());
        (before.sum::<usize>(), layout.properties[axis].1)
    });
    let vertices: Vec<Range<usize>> = (0..layout.count)
        .map(|index| layout.data + index * size..layout.data + (index + 1) * size)
        .collect();
    let point = |vertex: &Range<usize>| {
        let stored = &bytes[vertex.clone()];
        fields.map(|(start, scalar)| {
            scalar.value(&stored[start..start + scalar.size()], layout.encoding)
        })
    };
    let points = vertices.iter().map(point).collect();
    Ok((vertices, points))
}

fn read_text(bytes: &[u8], layout: &PlyLayout, axes: [usize; 3]) -> Result<Vertices, String> {
    let (mut vertices, mut points) = (Vec::new(), Vec::new());
    let mut at = layout.data;
    for (index, line) in
        bytes[layout.data..].split_inclusive(|&byte| byte == b'\n').take(layout.count).enumerate()
    {
        let text = std::str::from_utf8(line).unwrap_or_default();
        let fields: Vec<&str> = text.split_whitespace().collect();
        let value = |axis: usize| fields.get(axis).and_then(|field| field.parse::<f64>().ok());
        let [Some(x), Some(y), Some(z)] = axes.map(value) else {
            let line = layout.lines + index + 1;
            return Err(format!("line {line}: this vertex has no numbers for x, y and z"));
        };
        points.push([x, y, z]);
        vertices.push(at..at + line.trim_ascii_end().len());
        at += line.len();
    }
    if points.len() < layout.count {
        return Err(too_short(points.len(), layout.count));
    }
    Ok((vertices, points))
}

fn too_short(found: usize, count: usize) -> String {
    format!("the PLY file ends after {found} of {count} vertices")
}

impl PlyLayout {
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let mut layout = Self::default();
        let mut element = 0;
        for line in bytes.split_inclusive(|&byte| byte == b'\n') {
            layout.data += line.len();
            layout.lines += 1;
            let text = std::str::from_utf8(line).map_err(|_| "the PLY header is not text")?.trim();
            if layout.lines == 1 {
                if text != "ply" {
                    return Err("the file does not begin with `ply`".to_owned());
                }
                continue;
            }
            if text == "end_header" {
                return if layout.properties.is_empty() {
                    Err("the PLY header describes no vertices".to_owned())
                } else {
                    Ok(layout)
                };
            }
            layout
                .take(text, &mut element)
                .map_err(|what| format!("line {}: {what}: `{text}`", layout.lines))?;
        }
        Err("the PLY header has no end".to_owned())
    }

    /// Parses one header line, or returns its fault; `element` counts the elements so far.
    fn take(&mut self, text: &str, element: &mut usize) -> Result<(), &'static str> {
        let words: Vec<&str> = text.split_whitespace().collect();
        match words.as_slice() {
            ["format", encoding, ..] => {
                self.encoding = match *encoding {
                    "ascii" => PlyEncoding::Text,
                    "binary_little_endian" => PlyEncoding::Little,
                    "binary_big_endian" => PlyEncoding::Big,
                    _ => return Err("unknown PLY format"),
                };
            }
            ["element", name, count] => {
                *element += 1;
                if *element > 1 {
                    return Ok(());
                }
                if *name != "vertex" {
                    return Err("the first PLY element is not the vertices");
                }
                self.count = count.parse().map_err(|_| "not a count")?;
                return Ok(());
            }
            ["property", ..] if *element > 1 => return Ok(()),
            ["property", kind, name] => {
                let scalar = Scalar::named(kind).ok_or("unknown property type")?;
                self.properties.push(((*name).to_owned(), scalar));
            }
            ["property", ..] => return Err("vertices with lists are not read"),
            _ => {}
        }
        self.kept_lines.push(text.to_owned());
        Ok(())
    }
}

impl PlyFile {
    pub(super) fn write_kept(&self, file: File, kept: &[bool]) -> io::Result<()> {
        let mut out = BufWriter::new(file);
        let vertices = self.vertices.iter().zip(kept).filter(|(_, kept)| **kept);
        writeln!(out, "ply")?;
        let (before, properties): (Vec<_>, Vec<_>) =
            self.header.iter().partition(|line| !line.starts_with("property"));
        for line in before {
            writeln!(out, "{line}")?;
        }
        writeln!(out, "element vertex {}", vertices.clone().count())?;
        for line in properties {
            writeln!(out, "{line}")?;
        }
        writeln!(out, "end_header")?;
        let text = self.header.iter().any(|line| line.starts_with("format ascii"));
        for (vertex, _) in vertices {
            out.write_all(&self.bytes[vertex.clone()])?;
            if text {
                out.write_all(b"\n")?;
            }
        }
        out.flush()
    }
}

/// Writes points that have only coordinates, binary little-endian.
pub(super) fn write<'a>(file: File, points: impl Iterator<Item = &'a [f64; 3]>) -> io::Result<()> {
    let points: Vec<&[f64; 3]> = points.collect();
    let mut out = BufWriter::new(file);
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n\
         property double x\nproperty double y\nproperty double z\nend_header\n",
        points.len()
    )?;
    for value in points.into_iter().flatten() {
        out.write_all(&value.to_le_bytes())?;
    }
    out.flush()
}
