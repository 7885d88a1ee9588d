//! Particles over time, read back by VTK's own reader, as ParaView opens them.
use hvi_flow::vtkhdf;
use hvi_kit::view::{Cloud, Field, Moment};
use std::path::Path;
use std::process::Command;

/// Prints, a line a time: time, points, cells, bounds of the points, and the range of each array's components.
const READ: &str = "
import sys
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
reader = vtkHDFReader()
reader.SetFileName(sys.argv[1])
reader.UpdateInformation()
for t in reader.GetOutputInformation(0).Get(Pipeline.TIME_STEPS()):
    reader.UpdateTimeStep(t)
    out = reader.GetOutputDataObject(0)
    data = out.GetPointData()
    arrays = [data.GetArray(i) for i in range(data.GetNumberOfArrays())]
    ranges = [(a.GetName(), [a.GetRange(k) for k in range(a.GetNumberOfComponents())]) for a in arrays]
    print(out.GetClassName(), t, out.GetNumberOfPoints(), out.GetNumberOfCells(), out.GetBounds(), ranges)
";

/// The interpreter that has VTK.
fn python() -> std::path::PathBuf {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/venv/bin/python");
    assert!(python.exists(), "{} is missing: `sh setup.sh test` installs it with VTK's reader", python.display());
    python
}

/// Three times with other numbers of points each.
#[test]
fn vtk_reads_what_is_written() {
    let moment = |k: usize, n: usize| Moment {
        time: 1e-6 * k as f64,
        points: (0..n).map(|i| [i as f32, k as f32, 0.5]).collect(),
        fields: vec![
            Field { name: "velocity".into(), width: 3, values: (0..3 * n).map(|i| i as f32).collect() },
            Field { name: "pressure".into(), width: 1, values: (0..n).map(|i| (i + 10 * k) as f32).collect() },
        ],
    };
    let cloud = Cloud { title: "Particles".into(), moments: vec![moment(0, 1000), moment(1, 7), moment(2, 1001)] };
    let bytes = vtkhdf::encode(&cloud);
    assert_eq!(bytes, vtkhdf::encode(&cloud));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.vtkhdf");
    std::fs::write(&path, bytes).unwrap();
    let output = Command::new(python()).arg("-c").arg(READ).arg(&path).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    let lines: Vec<&str> = said.lines().collect();
    let expected = [
        "vtkPolyData 0.0 1000 1000 (0.0, 999.0, 0.0, 0.0, 0.5, 0.5) [('velocity', [(0.0, 2997.0), (1.0, 2998.0), (2.0, \
         2999.0)]), ('pressure', [(0.0, 999.0)])]",
        "vtkPolyData 1e-06 7 7 (0.0, 6.0, 1.0, 1.0, 0.5, 0.5) [('velocity', [(0.0, 18.0), (1.0, 19.0), (2.0, 20.0)]), \
         ('pressure', [(10.0, 16.0)])]",
        "vtkPolyData 2e-06 1001 1001 (0.0, 1000.0, 2.0, 2.0, 0.5, 0.5) [('velocity', [(0.0, 3000.0), (1.0, 3001.0), \
         (2.0, 3002.0)]), ('pressure', [(20.0, 1020.0)])]",
    ];
    assert_eq!(lines, expected, "{}", String::from_utf8_lossy(&output.stderr));
}
