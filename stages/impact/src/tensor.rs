//! Small 3 x 3 tensor arithmetic, for one particle or eight: symmetric tensors as xx, yy, zz, xy, yz, xz.
use hvi_kit::lanes::Real;

/// A velocity gradient L_ij = dv_i / dx_j [1/s].
pub type Gradient<R> = [[R; 3]; 3];
/// A symmetric tensor.
pub type Symmetric<R> = [R; 6];

/// Trace of L.
#[inline(always)]
pub fn trace<R: Real>(l: &Gradient<R>) -> R {
    l[0][0] + l[1][1] + l[2][2]
}

/// Determinant of `I + dt L`.
#[inline(always)]
pub fn determinant<R: Real>(l: &Gradient<R>, dt: f64) -> R {
    let mut m = *l;
    for i in 0..3 {
        for j in 0..3 {
            m[i][j] = m[i][j].times(dt);
        }
        m[i][i] = m[i][i].plus(1.0);
    }
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}

/// `S : L` for symmetric S.
#[inline(always)]
pub fn contract<R: Real>(s: &Symmetric<R>, l: &Gradient<R>) -> R {
    s[0] * l[0][0]
        + s[1] * l[1][1]
        + s[2] * l[2][2]
        + s[3] * (l[0][1] + l[1][0])
        + s[4] * (l[1][2] + l[2][1])
        + s[5] * (l[0][2] + l[2][0])
}

/// Von Mises equivalent of a deviator.
#[inline(always)]
pub fn equivalent<R: Real>(s: &Symmetric<R>) -> R {
    let normal = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
    let shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    (normal.times(1.5) + shear.times(3.0)).root()
}

/// Elastic trial deviator after `dt`: Jaumann's rate, `dS/dt = 2 G dev(D) + W S - S W`, with shear modulus `shear` [Pa].
#[inline(always)]
pub fn elastic_trial<R: Real>(s: &Symmetric<R>, l: &Gradient<R>, dt: f64, shear: f64) -> Symmetric<R> {
    let third = trace(l).times(1.0 / 3.0);
    let wxy = (l[0][1] - l[1][0]).times(0.5);
    let wyz = (l[1][2] - l[2][1]).times(0.5);
    let wxz = (l[0][2] - l[2][0]).times(0.5);
    let [xx, yy, zz, xy, yz, xz] = *s;
    let spin = [
        (wxy * xy + wxz * xz).times(2.0),
        (wyz * yz - wxy * xy).times(2.0),
        (wxz * xz + wyz * yz).times(-2.0),
        wxy * (yy - xx) + wxz * yz + wyz * xz,
        wyz * (zz - yy) - wxy * xz - wxz * xy,
        wxz * (zz - xx) + wxy * yz - wyz * xy,
    ];
    let strain = [
        l[0][0] - third,
        l[1][1] - third,
        l[2][2] - third,
        (l[0][1] + l[1][0]).times(0.5),
        (l[1][2] + l[2][1]).times(0.5),
        (l[0][2] + l[2][0]).times(0.5),
    ];
    let mut trial = *s;
    for k in 0..6 {
        trial[k] = s[k] + (spin[k] + strain[k].times(2.0 * shear)).times(dt);
    }
    trial
}
#[cfg(test)]
mod tests {
    use super::*;

    /// A rigid turn by small steps turns the stress with it: after a right angle sxx and syy have changed places.
    #[test]
    fn spin_turns_the_stress() {
        let l = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
        let n = 20_000;
        let dt = std::f64::consts::FRAC_PI_2 / n as f64;
        let start = [3.0, -1.0, -2.0, 0.5, 0.25, -0.125];
        let mut s = start;
        for _ in 0..n {
            s = elastic_trial(&s, &l, dt, 1e9);
        }
        // Forward Euler: the error of the angle's second order is pi^2 / (8 n) of the size.
        let expected = [-1.0, 3.0, -2.0, -0.5, -0.125, -0.25];
        for k in 0..6 {
            assert!((s[k] - expected[k]).abs() < 2e-3, "{k}: {} {}", s[k], expected[k]);
        }
    }

    #[test]
    fn determinant_of_a_product() {
        let l = [[0.1, 0.2, -0.3], [0.0, 0.4, 0.1], [0.2, -0.1, 0.05]];
        let by_hand: f64 = 1.1 * (1.4 * 1.05 - 0.1 * -0.1) - 0.2 * (0.0 * 1.05 - 0.1 * 0.2) - 0.3 * (0.0 - 1.4 * 0.2);
        assert!((determinant(&l, 1.0) - by_hand).abs() < 1e-15);
    }
}
