//! Points over time as VTKHDF, which VTK and ParaView open.
//!
//! Layout after "VTKHDF File Format", version 2.0 (Kitware): a PolyData whose points are vertices, all times one after the other, with a
//! group that says where each begins.
use crate::hdf5_file::{self, Column, Group, Mark, Values};
use hvi_kit::view::Cloud;

/// The bytes of a file with `cloud`; the same cloud gives the same bytes.
pub fn encode(cloud: &Cloud) -> Vec<u8> {
    let counts: Vec<i64> = cloud.moments.iter().map(|m| m.points.len() as i64).collect();
    let steps = counts.len();
    let starts: Vec<i64> = counts.iter().scan(0, |sum, n| Some(std::mem::replace(sum, *sum + n))).collect();
    let points = cloud.moments.iter().flat_map(|m| m.points.iter().flatten().copied()).collect();
    let fields = cloud.moments.first().map_or(&[][..], |m| &m.fields);
    let values = fields.iter().enumerate().map(|(k, field)| {
        let all = cloud.moments.iter().flat_map(|m| m.fields[k].values.iter().copied()).collect();
        column(&field.name, Values::Singles(all, field.width))
    });
    let mut columns =
        vec![column("Points", Values::Singles(points, 3)), column("NumberOfPoints", integers(counts.clone()))];
    let vertices = Group {
        name: "Vertices",
        marks: Vec::new(),
        columns: vec![
            column("NumberOfCells", integers(counts.clone())),
            column("NumberOfConnectivityIds", integers(counts.clone())),
            column("Connectivity", integers(counts.iter().flat_map(|&n| 0..n).collect())),
            column("Offsets", integers(counts.iter().flat_map(|&n| 0..=n).collect())),
        ],
        groups: Vec::new(),
    };
    let none = |name| Group {
        name,
        marks: Vec::new(),
        columns: vec![
            column("NumberOfCells", integers(vec![0; steps])),
            column("NumberOfConnectivityIds", integers(vec![0; steps])),
            column("Connectivity", integers(Vec::new())),
            column("Offsets", integers(vec![0; steps])),
        ],
        groups: Vec::new(),
    };
    // Column 0 is that of the vertices.
    let first_of_four = || Values::Integers(starts.iter().flat_map(|&n| [n, 0, 0, 0]).collect(), 4);
    let offsets = fields.iter().map(|field| column(&field.name, integers(starts.clone())));
    let time = Group {
        name: "Steps",
        marks: vec![("NSteps", Mark::Integer(steps as i64))],
        columns: vec![
            column("Values", Values::Numbers(cloud.moments.iter().map(|m| m.time).collect())),
            column("NumberOfParts", integers(vec![1; steps])),
            column("PartOffsets", integers((0..steps as i64).collect())),
            column("PointOffsets", integers(starts.clone())),
            column("CellOffsets", first_of_four()),
            column("ConnectivityIdOffsets", first_of_four()),
        ],
        groups: vec![Group {
            name: "PointDataOffsets",
            marks: Vec::new(),
            columns: offsets.collect(),
            groups: Vec::new(),
        }],
    };
    let data = Group { name: "PointData", marks: Vec::new(), columns: values.collect(), groups: Vec::new() };
    let root = Group {
        name: "VTKHDF",
        marks: vec![("Version", Mark::Integers(vec![2, 0])), ("Type", Mark::Word("PolyData"))],
        columns: std::mem::take(&mut columns),
        groups: vec![vertices, none("Lines"), none("Polygons"), none("Strips"), data, time],
    };
    hdf5_file::encode_tree(&Group { name: "", marks: Vec::new(), columns: Vec::new(), groups: vec![root] })
}

fn column(name: &str, values: Values) -> Column {
    Column { name: name.into(), values, attributes: Vec::new() }
}

fn integers(values: Vec<i64>) -> Values {
    Values::Integers(values, 1)
}
