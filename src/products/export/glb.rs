//! Writes `bottom.glb`: a mesh with pictures over it as binary glTF 2.0 (ISO/IEC 12113), for any 3D
//! program and for browsers.
//!
//! In glTF y is up: x is east, y up and z south, metres. The pictures are variants of the material
//! (`KHR_materials_variants`); programs without this extension show the first one.

use super::{ExportError, write_atomically};
use serde_json::{Value, json};
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// Numbers of kinds of data and settings in glTF.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const LINEAR: u32 = 9729;
const LINEAR_MIPMAP_LINEAR: u32 = 9987;
const CLAMP_TO_EDGE: u32 = 33071;

/// A mesh of triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct TexturedMesh {
    /// Name of the mesh.
    pub name: String,
    /// East, north and up of each corner, metres.
    pub places_m: Vec<[f32; 3]>,
    /// Normal of the mesh at each corner, of length 1: east, north, up.
    pub normals: Vec<[f32; 3]>,
    /// Place of each corner in the pictures: 0 to 1 from the left, 0 to 1 from the top.
    pub in_pictures: Vec<[f32; 2]>,
    /// Three corners of each triangle, counter-clockwise seen from above.
    pub triangles: Vec<[u32; 3]>,
    /// Name and PNG of each picture; all cover the same ground.
    pub pictures: Vec<(&'static str, Vec<u8>)>,
    /// Additional information on the mesh (`extras` of glTF).
    pub extras: Value,
}

/// Binary part of a file, and the JSON lists that describe it.
#[derive(Default)]
struct GlbParts {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl GlbParts {
    /// Adds some bytes; returns the index of their view.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view =
            json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend(bytes);
        // The next view must begin at a multiple of four.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds elements of `N` numbers each; returns the index of their accessor.
    fn floats<const N: usize>(&mut self, values: &[[f32; N]], kind: &str) -> usize {
        let view = self.view(bytemuck::cast_slice(values), Some(ARRAY_BUFFER));
        let ends = |start: f32, better: fn(f32, f32) -> f32| {
            let fold = |ends: [f32; N], value: &[f32; N]| {
                std::array::from_fn(|axis| better(ends[axis], value[axis]))
            };
            values.iter().fold([start; N], fold).to_vec()
        };
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind,
            "min": ends(f32::MAX, f32::min), "max": ends(f32::MIN, f32::max),
        }));
        self.accessors.len() - 1
    }

    fn triangles(&mut self, triangles: &[[u32; 3]]) -> usize {
        let view = self.view(bytemuck::cast_slice(triangles), Some(ELEMENT_ARRAY_BUFFER));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": 3 * triangles.len(), "type": "SCALAR",
        }));
        self.accessors.len() - 1
    }
}

/// Writes a mesh to a file.
pub(crate) fn glb(path: &Path, mesh: &TexturedMesh) -> Result<(), ExportError> {
    let (document, bytes) = document(mesh);
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    write_atomically(path, |file| {
        let mut out = BufWriter::new(file);
        let whole = 12 + 8 + text.len() + 8 + bytes.len();
        out.write_all(b"glTF")?;
        for number in [2, length(whole)?, length(text.len())?] {
            out.write_all(&number.to_le_bytes())?;
        }
        out.write_all(b"JSON")?;
        out.write_all(&text)?;
        out.write_all(&length(bytes.len())?.to_le_bytes())?;
        out.write_all(b"BIN\0")?;
        out.write_all(&bytes)?;
        out.flush()
    })
}

fn length(bytes: usize) -> std::io::Result<u32> {
    let too_large = |_| std::io::Error::other("a glTF file holds 4 GB at most");
    u32::try_from(bytes).map_err(too_large)
}

/// Returns the JSON document of a mesh and the bytes that it refers to.
fn document(mesh: &TexturedMesh) -> (Value, Vec<u8>) {
    // Converts east, north, up to a system in which y is up.
    let turned = |vectors: &[[f32; 3]]| -> Vec<[f32; 3]> {
        let turn = |[east, north, up]: &[f32; 3]| [*east, *up, -*north];
        vectors.iter().map(turn).collect()
    };
    let mut parts = GlbParts::default();
    let attributes = json!({
        "POSITION": parts.floats(&turned(&mesh.places_m), "VEC3"),
        "NORMAL": parts.floats(&turned(&mesh.normals), "VEC3"),
        "TEXCOORD_0": parts.floats(&mesh.in_pictures, "VEC2"),
    });
    let triangles = parts.triangles(&mesh.triangles);
    let pictures = mesh.pictures.iter();
    let images: Vec<Value> = pictures
        .map(|(name, png)| {
            json!({"name": name, "bufferView": parts.view(png, None), "mimeType": "image/png"})
        })
        .collect();
    let names = || mesh.pictures.iter().map(|(name, _)| name).enumerate();
    let material = |(index, name): (usize, &&str)| {
        json!({
            "name": name, "doubleSided": true,
            "pbrMetallicRoughness": {"baseColorTexture": {"index": index}, "metallicFactor": 0, "roughnessFactor": 1},
        })
    };
    let document = json!({
        "asset": {"version": "2.0", "generator": concat!("Bathyscope ", env!("CARGO_PKG_VERSION")), "extras": mesh.extras},
        "extensionsUsed": ["KHR_materials_variants"],
        "extensions": {"KHR_materials_variants": {
            "variants": names().map(|(_, name)| json!({"name": name})).collect::<Vec<_>>(),
        }},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": mesh.name, "mesh": 0}],
        "meshes": [{"name": mesh.name, "primitives": [{
            "attributes": attributes, "indices": triangles, "material": 0,
            "extensions": {"KHR_materials_variants": {
                "mappings": names().map(|(index, _)| json!({"material": index, "variants": [index]})).collect::<Vec<_>>(),
            }},
        }]}],
        "materials": names().map(material).collect::<Vec<_>>(),
        "textures": names().map(|(index, _)| json!({"sampler": 0, "source": index})).collect::<Vec<_>>(),
        "samplers": [{"magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE}],
        "images": images,
        "accessors": parts.accessors,
        "bufferViews": parts.views,
        "buffers": [{"byteLength": parts.bytes.len()}],
    });
    (document, parts.bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_is_y_and_south_is_z_and_every_part_begins_at_a_multiple_of_four() {
        let mesh = TexturedMesh {
            places_m: vec![[0.0, 0.0, -2.0], [4.0, 0.0, -3.0], [0.0, 5.0, -1.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            in_pictures: vec![[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            pictures: vec![("depth", vec![1, 2, 3]), ("mosaic", vec![4, 5])],
            ..TexturedMesh::default()
        };
        let (document, bytes) = document(&mesh);
        let accessor = &document["accessors"][0];
        assert_eq!(accessor["min"], json!([0.0, -3.0, -5.0]));
        assert_eq!(accessor["max"], json!([4.0, -1.0, 0.0]));
        let views = document["bufferViews"].as_array().expect("an array");
        assert_eq!(views.len(), 6);
        for view in views {
            let offset = view["byteOffset"].as_u64().expect("an offset");
            let length = view["byteLength"].as_u64().expect("a length");
            assert_eq!(offset % 4, 0);
            assert!(offset + length <= bytes.len() as u64);
        }
        let last = views[5]["byteOffset"].as_u64().expect("an offset") as usize;
        assert_eq!(bytes[last..last + 2], [4, 5]);
        let variants = &document["extensions"]["KHR_materials_variants"]["variants"];
        assert_eq!(variants[1]["name"], "mosaic");
    }
}
