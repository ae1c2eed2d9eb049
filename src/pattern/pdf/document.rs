//! The objects of a document around the contents of its pages.

use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::PageMode;
use pdf_writer::{Dict, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};

use super::super::sheet::Layer;
use super::super::style::style;
use super::Picture;
use super::canvas::{Canvas, POINTS};

/// The layer of frames, marks and bands, after those of the sheet.
pub(super) const PAGE_LAYER: usize = Layer::ALL.len();

/// Effort of compression: what is common.
const LEVEL: u8 = 6;

/// Pages while they are made.
pub(super) struct Document {
    /// Size in millimetres and compressed contents.
    pages: Vec<([f64; 2], Vec<u8>)>,
    hash: u128,
}

impl Document {
    pub fn new() -> Self {
        // FNV-1a.
        Self { pages: Vec::new(), hash: 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d }
    }

    fn feed(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.hash =
                (self.hash ^ u128::from(byte)).wrapping_mul(0x0100_0000_0000_0000_0000_013b);
        }
    }

    pub fn add(&mut self, size: [f64; 2], canvas: &Canvas) {
        self.feed(canvas.bytes());
        self.pages.push((size, compress_to_vec_zlib(canvas.bytes(), LEVEL)));
    }

    pub fn finish(mut self, title: &str, picture: Option<&Picture>) -> Vec<u8> {
        self.feed(title.as_bytes());
        let mut last = 0;
        let mut next = || {
            last += 1;
            Ref::new(last)
        };
        let [catalog, tree, info, plain, bold, image] = std::array::from_fn(|_| next());
        let layers: Vec<Ref> = (0..=PAGE_LAYER).map(|_| next()).collect();
        let pages: Vec<[Ref; 2]> = self.pages.iter().map(|_| [next(), next()]).collect();

        let mut pdf = Pdf::new();
        pdf.set_version(1, 6);
        let id = self.hash.to_be_bytes().to_vec();
        pdf.set_file_id((id.clone(), id));
        pdf.document_info(info).title(TextStr(title)).producer(TextStr("Cutflow"));

        let mut root = pdf.catalog(catalog);
        root.pages(tree).page_mode(PageMode::UseOC);
        let mut preferences = root.viewer_preferences();
        preferences.display_doc_title(true);
        preferences.pair(Name(b"PrintScaling"), Name(b"None"));
        preferences.pair(Name(b"PickTrayByPDFSize"), true);
        preferences.pair(Name(b"Duplex"), Name(b"Simplex"));
        preferences.finish();
        optional_content(root.insert(Name(b"OCProperties")).dict(), &layers);
        root.finish();

        let count = i32::try_from(pages.len()).unwrap_or(i32::MAX);
        pdf.pages(tree).kids(pages.iter().map(|page| page[0])).count(count);
        for (font, name) in [(plain, b"Helvetica".as_slice()), (bold, b"Helvetica-Bold")] {
            pdf.type1_font(font)
                .base_font(Name(name))
                .encoding_predefined(Name(b"WinAnsiEncoding"));
        }
        let names = Layer::ALL.iter().map(|&layer| style(layer).label).chain(["PAGE"]);
        for (&layer, name) in layers.iter().zip(names) {
            let mut group = pdf.indirect(layer).dict();
            group.pair(Name(b"Type"), Name(b"OCG")).pair(Name(b"Name"), Str(name.as_bytes()));
        }
        for (&[page, contents], (size, bytes)) in pages.iter().zip(&self.pages) {
            let mut object = pdf.page(page);
            #[expect(clippy::cast_possible_truncation, reason = "pdf-writer has 32 bits")]
            let [width, height] = size.map(|x| (x * POINTS) as f32);
            object.parent(tree).contents(contents).media_box(Rect::new(0.0, 0.0, width, height));
            let mut resources = object.resources();
            resources.fonts().pair(Name(b"F0"), plain).pair(Name(b"F1"), bold);
            if picture.is_some() {
                resources.x_objects().pair(Name(b"Im0"), image);
            }
            let mut properties = resources.insert(Name(b"Properties")).dict();
            for (index, &layer) in layers.iter().enumerate() {
                properties.pair(Name(format!("OC{index}").as_bytes()), layer);
            }
            properties.finish();
            resources.finish();
            object.finish();
            pdf.stream(contents, bytes).filter(Filter::FlateDecode);
        }
        if let Some(Picture { width, height, rgb }) = picture {
            let bytes = compress_to_vec_zlib(rgb, LEVEL);
            let mut object = pdf.image_xobject(image, &bytes);
            let [width, height] = [width, height].map(|&x| i32::try_from(x).unwrap_or(i32::MAX));
            object.filter(Filter::FlateDecode);
            object.width(width).height(height).bits_per_component(8);
            object.color_space().device_rgb();
        } else {
            pdf.indirect(image).primitive(pdf_writer::Null);
        }
        pdf.finish()
    }
}

/// All layers are on; readers list them in their order.
fn optional_content(mut properties: Dict, layers: &[Ref]) {
    properties.insert(Name(b"OCGs")).array().items(layers);
    let mut default = properties.insert(Name(b"D")).dict();
    default.pair(Name(b"Name"), Str(b"Pattern")).pair(Name(b"BaseState"), Name(b"ON"));
    for key in [b"ON".as_slice(), b"Order"] {
        default.insert(Name(key)).array().items(layers);
    }
}
