//! Pictures written and read back.

mod support;

use std::io::{self, Cursor, Write};

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
use halfline::geometry::NO_FACE;
use halfline::progress::NoProgress;
use halfline_render::{Background, RenderSettings, Rendering, Shading, render};
use support::{Builder, matte};

fn picture(shading: Shading, background: Background) -> Rendering {
    let scene = Builder::default().icosphere([0.0; 3], 1.0, 1, matte(0.5, 0.4, 0.3)).plain_scene();
    let settings = RenderSettings::new(33, 21).with(|s| {
        s.samples = 3;
        s.shading = shading;
        s.background = background;
    });
    render(&scene, &settings, &NoProgress).unwrap()
}

fn decode(bytes: &[u8]) -> (png::ColorType, Vec<u8>) {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    assert_eq!(reader.info().srgb, Some(png::SrgbRenderingIntent::RelativeColorimetric));
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (33, 21));
    (info.color_type, pixels)
}

#[test]
fn png_is_opaque_where_all_is_covered() {
    let picture = picture(Shading::Clay, Background::Studio);
    let mut bytes = Vec::new();
    picture.write_png(&mut bytes).unwrap();
    let (color_type, pixels) = decode(&bytes);
    assert_eq!(color_type, png::ColorType::Rgb);
    let expected: Vec<u8> = picture.to_srgb8().iter().flat_map(|p| p[..3].to_vec()).collect();
    assert_eq!(pixels, expected);
}

#[test]
fn png_keeps_alpha_straight() {
    let picture = picture(Shading::Normal, Background::Transparent);
    let mut bytes = Vec::new();
    picture.write_png(&mut bytes).unwrap();
    let (color_type, pixels) = decode(&bytes);
    assert_eq!(color_type, png::ColorType::Rgba);
    assert_eq!(pixels, picture.to_srgb8().as_flattened());
    // At an outline a third of the samples hit, and the colour is as bright as inside.
    let edge = picture.color.iter().find(|c| c[3] > 0.2 && c[3] < 0.5).unwrap();
    assert!(edge[..3].iter().any(|&v| v > 0.3), "{edge:?}");
}

#[test]
fn exr_holds_every_layer_to_the_bit() {
    for (shading, background) in
        [(Shading::Steps, Background::Studio), (Shading::Normal, Background::Transparent)]
    {
        let picture = picture(shading, background);
        let mut bytes = Cursor::new(Vec::new());
        picture.write_exr(&mut bytes).unwrap();
        bytes.set_position(0);
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(bytes)
            .unwrap();
        assert_eq!(image.layer_data.size.0, 33);
        assert_eq!(image.layer_data.size.1, 21);
        let channels = &image.layer_data.channel_data.list;
        let find = |name: &str| {
            let channel = channels.iter().find(|c| c.name.eq(name));
            channel.map(|c| &c.sample_data)
        };
        let expect = |name: &str, values: Vec<f32>| match find(name) {
            Some(FlatSamples::F32(samples)) => assert_eq!(*samples, values, "{name}"),
            other => panic!("{name}: {other:?}"),
        };
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            expect(name, picture.color.iter().map(|p| p[c] * p[3]).collect());
        }
        expect("A", picture.color.iter().map(|p| p[3]).collect());
        expect("Z", picture.depth.clone());
        for (c, name) in ["N.X", "N.Y", "N.Z"].into_iter().enumerate() {
            expect(name, picture.normal.iter().map(|n| n[c]).collect());
        }
        match find("id") {
            Some(FlatSamples::U32(samples)) => {
                assert_eq!(*samples, picture.face);
                assert!(samples.contains(&NO_FACE) && samples.iter().any(|&id| id < 80));
            }
            other => panic!("id: {other:?}"),
        }
        assert_eq!(find("steps.nodes").is_some(), shading == Shading::Steps);
        assert_eq!(channels.len(), if shading == Shading::Steps { 11 } else { 9 });
    }
}

/// A disk that is full after so many bytes.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if bytes.len() > self.0 {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        self.0 -= bytes.len();
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl io::Seek for Full {
    fn seek(&mut self, _: io::SeekFrom) -> io::Result<u64> {
        Ok(0)
    }
}

#[test]
fn a_full_disk_is_an_error() {
    let picture = picture(Shading::Clay, Background::Studio);
    for room in [0, 10, 200] {
        assert_eq!(picture.write_png(Full(room)).unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(picture.write_exr(Full(room)).unwrap_err().kind(), io::ErrorKind::StorageFull);
    }
}
