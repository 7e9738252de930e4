//! The One Euro filter: a low-pass whose cut-off rises with speed (Casiez, Roussel and Vogel, CHI 2012).

use grimace_plugin::{Call, Fault, Node, Outputs, Schema};

/// Calms slow jitter and follows fast moves.
pub struct OneEuro;

/// α = 1 / (1 + τ·f) with τ = 1 / (2π·cut-off in Hz) and f the rate in Hz: how much of a new value is taken (Eq. 3 there).
fn share(cutoff_hz: f64, rate_hz: f64) -> f64 {
    1.0 / (1.0 + rate_hz / (std::f64::consts::TAU * cutoff_hz))
}

impl Node for OneEuro {
    fn schema() -> Schema {
        Schema::new(
            "one_euro",
            "Calms jitter in still moments and follows fast moves. It looks at the past alone, so it lags a little.",
        )
        .takes("curves", "Curves", "one value per channel and frame")
        .gives("curves", "Curves", "the same channels and frames, filtered")
        .number("min_cutoff_hz", 1.0, 0.001..=120.0, "Cut-off where nothing moves. Lower is calmer.")
        .number("beta", 0.5, 0.0..=100.0, "How much faster moves raise the cut-off. Higher lags less.")
        .number("speed_cutoff_hz", 1.0, 0.001..=120.0, "Cut-off for the speed itself.")
    }

    fn evaluate(call: &mut Call) -> Result<Outputs, Fault> {
        let (least_hz, beta, speed_hz) =
            (call.number("min_cutoff_hz"), call.number("beta"), call.number("speed_cutoff_hz"));
        let mut curves = call.curves("curves")?;
        let (rate_hz, channels) = (curves.frames.rate_hz, curves.channels.len());
        let speed_share = share(speed_hz, rate_hz);
        let mut state = vec![(f64::NAN, 0.0); channels];
        for (t, frame) in curves.values.chunks_exact_mut(channels.max(1)).enumerate() {
            if t % 1000 == 0 {
                call.progress(t as f64 / f64::from(curves.frames.count))?;
            }
            for (value, (last, speed)) in frame.iter_mut().zip(&mut state) {
                let raw = f64::from(*value);
                if last.is_nan() {
                    *last = raw;
                    continue;
                }
                *speed += speed_share * ((raw - *last) * rate_hz - *speed);
                *last += share(least_hz + beta * speed.abs(), rate_hz) * (raw - *last);
                *value = *last as f32;
            }
        }
        Ok(Outputs::of("curves", curves))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grimace_plugin::{Curves, Frames};

    fn curves(values: Vec<f32>) -> Curves {
        let frames = Frames { first: 1, rate_hz: 60.0, count: values.len() as u32 };
        Curves { frames, channels: vec!["jawOpen".to_owned()], values }
    }

    #[test]
    fn still_curves_stay_and_jitter_is_calmed() {
        let still = curves(vec![0.25; 50]);
        let outputs = OneEuro::evaluate(&mut Call::to::<OneEuro>().with("curves", still.clone())).unwrap();
        assert_eq!(outputs.curves("curves"), Some(&still));
        let jitter: Vec<f32> = (0..200).map(|t| 0.5 + if t % 2 == 0 { 0.01 } else { -0.01 }).collect();
        let outputs = OneEuro::evaluate(&mut Call::to::<OneEuro>().with("curves", curves(jitter))).unwrap();
        let calm = &outputs.curves("curves").unwrap().values[100..];
        assert!(calm.iter().all(|value| (value - 0.5).abs() < 0.004), "{calm:?}");
    }
}
