//! Tables of markers as capture systems export them, made from positions, with the liberties that each takes.

use std::fmt::Write;

/// What a table is to hold. Coordinates are in the unit that it states; absent ones are missing.
#[derive(Debug, Clone)]
pub struct Tables {
    pub names: Vec<String>,
    pub points: Vec<Option<[f32; 3]>>,
    pub first_frame: i64,
    pub rate_hz: f64,
    pub unit: &'static str,
    pub line_end: &'static str,
    /// What stands in the cells of a missing point.
    pub missing: &'static str,
    /// Whether empty cells at the end of a row are left away.
    pub trimmed: bool,
    pub byte_order_mark: bool,
}

impl Tables {
    pub fn new(names: Vec<String>, points: Vec<Option<[f32; 3]>>) -> Self {
        Self {
            names,
            points,
            first_frame: 1,
            rate_hz: 60.0,
            unit: "mm",
            line_end: "\n",
            missing: "",
            trimmed: false,
            byte_order_mark: false,
        }
    }

    pub fn frames(&self) -> usize {
        self.points.len() / self.names.len()
    }

    fn finish(&self, lines: &[String]) -> Vec<u8> {
        let mark = if self.byte_order_mark { "\u{feff}" } else { "" };
        (mark.to_owned() + &lines.iter().map(|line| line.clone() + self.line_end).collect::<String>()).into_bytes()
    }

    /// The three cells of a marker in a frame.
    fn cells(&self, frame: usize, marker: usize) -> [String; 3] {
        match self.points[frame * self.names.len() + marker] {
            Some(point) => point.map(|number| number.to_string()),
            None => [(); 3].map(|()| self.missing.to_owned()),
        }
    }

    fn row(&self, cells: &[String], separator: &str) -> String {
        let row = cells.join(separator);
        if self.trimmed { row.trim_end_matches(separator).to_owned() } else { row }
    }

    fn frame(&self, frame: usize) -> i64 {
        self.first_frame + frame as i64
    }

    fn time(&self, frame: usize) -> String {
        format!("{:.3}", frame as f64 / self.rate_hz)
    }

    /// A TRC file; with or without the line of axes and the blank one.
    pub fn trc(&self, axes: bool, blank: bool) -> Vec<u8> {
        let (rate, count, unit) = (self.rate_hz, self.frames(), self.unit);
        let mut lines = vec![
            "PathFileType\t4\t(X/Y/Z)\ttake one.trc".to_owned(),
            "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames"
                .to_owned(),
            format!("{rate}\t{rate}\t  {count}\t{}\t{unit}\t{rate}\t1\t{count}", self.names.len()),
            format!("Frame#\tTime\t{}\t\t", self.names.join("\t\t\t")),
        ];
        if axes {
            let numbered = |marker: usize| format!("X{marker}\tY{marker}\tZ{marker}");
            lines.push(format!("\t\t{}", (1..=self.names.len()).map(numbered).collect::<Vec<_>>().join("\t")));
        }
        if blank {
            lines.push(String::new());
        }
        for frame in 0..count {
            let mut cells = vec![self.frame(frame).to_string(), self.time(frame)];
            cells.extend((0..self.names.len()).flat_map(|marker| self.cells(frame, marker)));
            lines.push(self.row(&cells, "\t"));
        }
        self.finish(&lines)
    }

    /// An export of Motive in the format of a version (`1.21` has bare headers, `1.22` names them, `1.24` knows
    /// parents), with a rigid body of rotations of so many columns (4 quaternions, 3 angles) before the markers, and
    /// its expected marker behind them.
    pub fn motive(&self, version: &str, rotation: usize) -> Vec<u8> {
        let labelled = version > "1.21";
        let (rate, count) = (self.rate_hz, self.frames());
        let kind = if rotation == 4 { "Quaternion" } else { "XYZ" };
        let facts = format!(
            "Format Version,{version},Take Name,\"Take, one\",Capture Frame Rate,{rate},Export Frame Rate,{rate},Total \
             Exported Frames,{count},Rotation Type,{kind},Length Units,{},Coordinate Space,Global",
            self.unit
        );
        let body = rotation + 4;
        let line = |label: &str, of_body: &str, of_marker: &dyn Fn(&str) -> String, of_expected: &str| {
            let mut line = format!(",{}", if labelled { label } else { "" });
            (0..body).for_each(|_| write!(line, ",{of_body}").unwrap());
            for name in &self.names {
                (0..3).for_each(|_| write!(line, ",{}", of_marker(name)).unwrap());
            }
            (0..4).for_each(|_| write!(line, ",{of_expected}").unwrap());
            line
        };
        let quoted = |name: &str| format!("\"{name}\"");
        let mut lines = vec![facts, String::new()];
        lines.push(line("Type", "Rigid Body", &|_| "Marker".into(), "Rigid Body Marker"));
        lines.push(line("Name", "Hat", &quoted, "Hat:1"));
        lines.push(line("ID", "CF51", &|_| "\"8392\"".into(), "CF52"));
        if version >= "1.24" {
            lines.push(line("Parent", "", &|_| String::new(), "CF51"));
        }
        let measures = ["Rotation"; 4][..rotation].join(",");
        let positions = ["Position"; 3].join(",");
        let names = vec![positions.clone(); self.names.len()].join(",");
        lines.push(format!(",,{measures},{positions},Mean Marker Error,{names},{positions},Marker Quality"));
        let axes = vec!["X,Y,Z"; self.names.len()].join(",");
        let rotations = ["X", "Y", "Z", "W"][..rotation].join(",");
        let time = if labelled { "Time (Seconds)" } else { "Time" };
        lines.push(format!("Frame,{time},{rotations},X,Y,Z,,{axes},X,Y,Z,"));
        for frame in 0..count {
            let mut cells = vec![self.frame(frame).to_string(), self.time(frame)];
            cells.extend((0..body).map(|column| format!("0.{column}")));
            cells.extend((0..self.names.len()).flat_map(|marker| self.cells(frame, marker)));
            cells.extend(["9.5", "9.25", "9.125", "0.99"].map(str::to_owned));
            lines.push(self.row(&cells, ","));
        }
        self.finish(&lines)
    }

    /// An export of Nexus with other sections before and behind the trajectories, and with velocities.
    pub fn vicon(&self, separator: &str, devices: bool, velocities: bool) -> Vec<u8> {
        let width = if velocities { 6 } else { 3 };
        let mut lines = Vec::new();
        if devices {
            lines.extend(
                ["Devices", "1000", ",,Force,,", "Frame,Sub Frame,Fx,Fy,Fz", ",,N,N,N", "1,0,1,2,3", "1,1,4,5,6", ""]
                    .map(|line| line.replace(',', separator)),
            );
        }
        let wide = separator.repeat(2 + width * self.names.len() - 1);
        lines.push(format!("Trajectories{wide}"));
        lines.push(format!("{}{wide}", self.rate_hz));
        let gap = separator.repeat(width);
        lines.push(format!("{separator}{separator}{}", self.names.join(&gap)));
        let columns = |of: &[&str]| vec![of[..width].join(separator); self.names.len()].join(separator);
        lines.push(["Frame", "Sub Frame", &columns(&["X", "Y", "Z", "X'", "Y'", "Z'"])].join(separator));
        let unit = self.unit;
        let speed = format!("{unit}/s");
        lines.push(["", "", &columns(&[unit, unit, unit, &speed, &speed, &speed])].join(separator));
        for frame in 0..self.frames() {
            let mut cells = vec![self.frame(frame).to_string(), "0".to_owned()];
            for marker in 0..self.names.len() {
                cells.extend(self.cells(frame, marker));
                cells.extend((3..width).map(|_| "77".to_owned()));
            }
            lines.push(self.row(&cells, separator));
        }
        if devices {
            lines.extend(
                ["", "Model Outputs", "60", ",,anna:LHipAngles", "Frame,Sub Frame,X,Y,Z", ",,deg,deg,deg", "1,0,1,2,3"]
                    .map(|line| line.replace(',', separator)),
            );
        }
        self.finish(&lines)
    }

    /// An output of `OpenFace` with landmarks in the picture, and in space unless they are `flat`. A frame succeeded
    /// where its first point is there; where it did not, numbers of another frame stand.
    pub fn openface(&self, flat: bool, blanks: bool) -> Vec<u8> {
        let landmarks = self.names.len();
        let comma = if blanks { ", " } else { "," };
        let mut head: Vec<String> =
            ["frame", "face_id", "timestamp", "confidence", "success", "gaze_0_x"].map(str::to_owned).into();
        let axes: &[&str] = if flat { &["x", "y"] } else { &["x", "y", "X", "Y", "Z"] };
        for axis in axes {
            head.extend((0..landmarks).map(|index| format!("{axis}_{index}")));
        }
        head.push("AU01_r".to_owned());
        let mut lines = vec![head.join(comma)];
        for frame in 0..self.frames() {
            let points = &self.points[frame * landmarks..(frame + 1) * landmarks];
            let there = points[0].is_some();
            let mut cells = vec![self.frame(frame).to_string(), "0".into(), self.time(frame), "0.98".into()];
            cells.extend([u8::from(there).to_string(), "0.1".to_owned()]);
            cells.extend((0..2 * landmarks).map(|pixel| format!("{pixel}.5")));
            if !flat {
                for axis in 0..3 {
                    cells.extend(points.iter().map(|point| point.unwrap_or([5.0; 3])[axis].to_string()));
                }
            }
            cells.push("0.00".to_owned());
            lines.push(cells.join(comma));
        }
        self.finish(&lines)
    }
}
