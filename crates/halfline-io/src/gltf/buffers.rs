//! Buffers and views of them: from the binary chunk, from data URIs, from files in the folder.

use std::cell::{Cell, OnceCell, RefCell};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::document::Document;
use crate::sibling;
use halfline::error::{Error, Result};

/// Loads buffers when they are first needed: those of animations alone never are.
pub(super) struct Buffers<'a> {
    pub path: &'a Path,
    pub document: &'a Document,
    binary_chunk: Option<&'a [u8]>,
    loaded: Vec<OnceCell<Bytes<'a>>>,
    files: RefCell<HashMap<PathBuf, Rc<[u8]>>>,
    bytes_read: Cell<u64>,
}

/// Bytes borrowed from the file, or shared.
pub(super) enum Bytes<'a> {
    Borrowed(&'a [u8]),
    Shared(Rc<[u8]>),
}

impl std::ops::Deref for Bytes<'_> {
    type Target = [u8];
    fn deref(&self) -> &[u8] {
        match self {
            Bytes::Borrowed(bytes) => bytes,
            Bytes::Shared(bytes) => bytes,
        }
    }
}

/// Part of a buffer.
pub(super) struct View<'b> {
    pub bytes: &'b [u8],
    pub stride: Option<u64>,
}

impl<'a> Buffers<'a> {
    pub fn new(
        path: &'a Path,
        file_length: usize,
        document: &'a Document,
        binary_chunk: Option<&'a [u8]>,
    ) -> Buffers<'a> {
        Buffers {
            path,
            document,
            binary_chunk,
            loaded: document.buffers.iter().map(|_| OnceCell::new()).collect(),
            files: RefCell::default(),
            bytes_read: Cell::new(file_length as u64),
        }
    }

    /// Sizes of all files read so far, together.
    pub fn bytes_read(&self) -> u64 {
        self.bytes_read.get()
    }

    /// The bytes of a buffer view.
    pub fn view(&self, index: u32) -> Result<View<'_>> {
        let place = || format!("buffer view {index}");
        let views = &self.document.buffer_views;
        let Some(view) = views.get(index as usize) else {
            let reason = format!("the file has {} buffer views", views.len());
            return Err(Error::format(self.path, place(), reason));
        };
        if view.extensions.as_ref().is_some_and(|extensions| extensions.meshopt.is_some()) {
            return Err(unsupported_extension(self.path, place(), "EXT_meshopt_compression"));
        }
        let buffer = self.buffer(view.buffer)?;
        let bytes = usize::try_from(view.byte_offset)
            .ok()
            .and_then(|offset| buffer.get(offset..))
            .and_then(|rest| rest.get(..usize::try_from(view.byte_length).ok()?));
        match bytes {
            Some(bytes) => Ok(View { bytes, stride: view.byte_stride }),
            None => Err(Error::format(
                self.path,
                place(),
                format!(
                    "{} bytes from byte {} reach past the {} bytes of buffer {}",
                    view.byte_length,
                    view.byte_offset,
                    buffer.len(),
                    view.buffer
                ),
            )),
        }
    }

    fn buffer(&self, index: u32) -> Result<&[u8]> {
        let error = |reason: String| Error::format(self.path, format!("buffer {index}"), reason);
        let Some(buffer) = self.document.buffers.get(index as usize) else {
            return Err(error(format!("the file has {} buffers", self.document.buffers.len())));
        };
        let cell = &self.loaded[index as usize];
        let bytes = match cell.get() {
            Some(bytes) => bytes,
            None => {
                let bytes = match (&buffer.uri, self.binary_chunk) {
                    (Some(uri), _) => match self.resolve(uri) {
                        Ok(Some(bytes)) => bytes,
                        Ok(None) => return Err(error(format!("{} is not there", short(uri)))),
                        Err(Refusal::Reason(reason)) => return Err(error(reason)),
                        Err(Refusal::Error(error)) => return Err(error),
                    },
                    (None, Some(chunk)) if index == 0 => Bytes::Borrowed(chunk),
                    (None, _) => {
                        return Err(error("has no uri, and no binary chunk holds it".to_owned()));
                    }
                };
                cell.get_or_init(|| bytes)
            }
        };
        // The end of the bytes may be padding.
        match usize::try_from(buffer.byte_length).ok().and_then(|length| bytes.get(..length)) {
            Some(bytes) => Ok(bytes),
            None => Err(error(format!(
                "byteLength is {}, but it has {} bytes",
                buffer.byte_length,
                bytes.len()
            ))),
        }
    }

    /// The content of a data URI, or of the file that a relative URI names; `None` if that file
    /// is missing.
    pub fn resolve(&self, uri: &str) -> std::result::Result<Option<Bytes<'a>>, Refusal> {
        if let Some(data) = strip_prefix_ignoring_case(uri, "data:") {
            let bytes = decode_data(data).map_err(|e| Refusal::Reason(e.to_owned()))?;
            return Ok(Some(Bytes::Shared(bytes.into())));
        }
        let place = self.place_of(uri).map_err(Refusal::Reason)?;
        if let Some(bytes) = self.files.borrow().get(&place) {
            return Ok(Some(Bytes::Shared(bytes.clone())));
        }
        let Some(bytes) = sibling::read(&place).map_err(Refusal::Error)? else { return Ok(None) };
        self.bytes_read.set(self.bytes_read.get() + bytes.len() as u64);
        let bytes: Rc<[u8]> = bytes.into();
        self.files.borrow_mut().insert(place, bytes.clone());
        Ok(Some(Bytes::Shared(bytes)))
    }

    /// Where the file lies that a URI names, or why it is refused.
    fn place_of(&self, uri: &str) -> std::result::Result<PathBuf, String> {
        let refuse = |reason: &str| format!("{} {reason}", short(uri));
        // Looked at before and after decoding: `http:` and `http%3A` are both refused.
        if sibling::has_scheme(uri) {
            return Err(refuse("names a scheme or a drive; only files beside the mesh are read"));
        }
        let name = percent_encoding::percent_decode_str(uri)
            .decode_utf8()
            .map_err(|_| refuse("is not UTF-8 once decoded"))?;
        sibling::locate(self.path, &name).map_err(refuse)
    }

    /// Refuses a document that names anything outside of its folder, needed or not: such a file
    /// was not made for this place.
    pub fn check_uris(&self) -> Result<()> {
        let buffers = self.document.buffers.iter().map(|buffer| buffer.uri.as_deref());
        let images = self.document.images.iter().map(|image| image.uri.as_deref());
        let named = (buffers.enumerate().map(|(index, uri)| ("buffer", index, uri)))
            .chain(images.enumerate().map(|(index, uri)| ("image", index, uri)));
        for (kind, index, uri) in named {
            let Some(uri) = uri.filter(|uri| strip_prefix_ignoring_case(uri, "data:").is_none())
            else {
                continue;
            };
            self.place_of(uri)
                .map_err(|reason| Error::format(self.path, format!("{kind} {index}"), reason))?;
        }
        Ok(())
    }
}

/// Why a URI was not resolved.
pub(super) enum Refusal {
    /// The URI itself is no good.
    Reason(String),
    /// The file it names is there and cannot be read.
    Error(Error),
}

/// The error for a feature without which the geometry cannot be read.
pub(super) fn unsupported_extension(path: &Path, place: impl Into<String>, name: &str) -> Error {
    Error::format(path, place, format!("extension {name} is required and not supported"))
}

/// What follows `data:` in a data URI (RFC 2397).
fn decode_data(data: &str) -> std::result::Result<Vec<u8>, &'static str> {
    let (header, content) = data.split_once(',').ok_or("a data URI needs a comma")?;
    if !header.to_ascii_lowercase().ends_with(";base64") {
        return Ok(percent_encoding::percent_decode_str(content).collect());
    }
    let lenient = GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true);
    GeneralPurpose::new(&base64::alphabet::STANDARD, lenient)
        .decode(content)
        .map_err(|_| "the data URI is not valid base64")
}

fn strip_prefix_ignoring_case<'s>(text: &'s str, prefix: &str) -> Option<&'s str> {
    let (head, tail) = text.split_at_checked(prefix.len())?;
    head.eq_ignore_ascii_case(prefix).then_some(tail)
}

/// A URI as it can stand in an error message.
fn short(uri: &str) -> String {
    crate::lines::quoted(uri.as_bytes())
}
