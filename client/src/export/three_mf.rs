//! 3MF, core specification 1.3: a package of XML parts that names its unit, mm.
//!
//! The format holds no normals: outside is where corners run anticlockwise.
//! Invariant: the same mesh makes the same bytes; the package carries no date.

use std::io::{self, Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::SolidMesh;

const TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"#;
const RELATIONS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Id="rel0" Target="/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"#;

pub(super) fn write(mesh: &SolidMesh, out: &mut impl io::Write) -> io::Result<()> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    let mut package = ZipWriter::new(Cursor::new(Vec::new()));
    package.start_file("[Content_Types].xml", options)?;
    package.write_all(TYPES.as_bytes())?;
    package.start_file("_rels/.rels", options)?;
    package.write_all(RELATIONS.as_bytes())?;
    package.start_file("3D/3dmodel.model", options)?;
    package.write_all(model(mesh).as_bytes())?;
    out.write_all(package.finish()?.get_ref())
}

fn model(mesh: &SolidMesh) -> String {
    use std::fmt::Write;
    let mut text = String::from(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xml:lang="en" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
<metadata name="Application">Pottery studio</metadata>
<resources><object id="1" type="model" name="pot"><mesh><vertices>
"#,
    );
    for [x, y, z] in mesh.corners_mm() {
        writeln!(text, r#"<vertex x="{x}" y="{y}" z="{z}"/>"#).expect("a text in memory can be written");
    }
    text.push_str("</vertices><triangles>\n");
    for [a, b, c] in mesh.facets() {
        writeln!(text, r#"<triangle v1="{a}" v2="{b}" v3="{c}"/>"#).expect("a text in memory can be written");
    }
    text.push_str("</triangles></mesh></object></resources>\n<build><item objectid=\"1\"/></build>\n</model>\n");
    text
}
