//! Builds glTF documents.

use base64::Engine;
use serde_json::{Value, json};

/// A document under construction, with its one buffer.
#[derive(Clone)]
pub struct Build {
    pub binary: Vec<u8>,
    pub json: Value,
}

impl Build {
    /// A document without anything in it.
    pub fn new() -> Build {
        let json = json!({
            "asset": {"version": "2.0"},
            "bufferViews": [], "accessors": [], "meshes": [], "nodes": [],
        });
        Build { binary: Vec::new(), json }
    }

    /// One mesh of one primitive at the origin: a triangle.
    pub fn triangle() -> Build {
        let mut build = Build::new();
        let positions = build.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        build.mesh(json!([{"attributes": {"POSITION": positions}}]));
        build.push("nodes", json!({"mesh": 0}));
        build
    }

    /// Adds to a list of the document; returns the index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub fn mesh(&mut self, primitives: Value) -> usize {
        self.push("meshes", json!({"primitives": primitives}))
    }

    /// Adds bytes to the buffer, and a view of them.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.binary.len();
        self.binary.extend_from_slice(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.push(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}),
        )
    }

    pub fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "type": kind, "componentType": component, "count": count}),
        )
    }

    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => panic!("{kind}"),
        };
        self.accessor(kind, 5126, values.len() / width, &bytes)
    }

    pub fn indices(&mut self, component: u32, values: &[u32]) -> usize {
        let size = match component {
            5121 => 1,
            5123 => 2,
            5125 => 4,
            _ => panic!("{component}"),
        };
        let bytes: Vec<u8> =
            values.iter().flat_map(|value| value.to_le_bytes()[..size].to_vec()).collect();
        self.accessor("SCALAR", component, values.len(), &bytes)
    }

    /// The document, with its buffer at `uri`.
    pub fn with_uri(&self, uri: &str) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"uri": uri, "byteLength": self.binary.len()}]);
        serde_json::to_vec_pretty(&json).unwrap()
    }

    /// The document, with its buffer embedded.
    pub fn embedded(&self) -> Vec<u8> {
        let data = base64::engine::general_purpose::STANDARD.encode(&self.binary);
        self.with_uri(&format!("data:application/octet-stream;base64,{data}"))
    }

    /// The binary container.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        let mut text = serde_json::to_vec(&json).unwrap();
        text.resize(text.len().next_multiple_of(4), b' ');
        glb_of(&[(b"JSON", &text), (b"BIN\0", &self.binary)])
    }
}

/// A container of the given chunks.
pub fn glb_of(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut glb = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, bytes) in chunks {
        glb.extend((bytes.len() as u32).to_le_bytes());
        glb.extend_from_slice(*kind);
        glb.extend_from_slice(bytes);
    }
    let length = glb.len() as u32;
    glb[8..12].copy_from_slice(&length.to_le_bytes());
    glb
}
