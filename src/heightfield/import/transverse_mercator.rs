//! Transverse Mercator back to longitude and latitude, by Krüger's series in the third flattening to its sixth order:
//! within nanometres of the truth as far as 3900 km from the central meridian. (Krüger 1912; Karney 2011, "Transverse
//! Mercator with an accuracy of a few nanometers", J. Geodesy 85, equations 11, 15, 18–21 and 36.)

/// WGS 84's and GRS 80's equatorial radius, metres.
const RADIUS: f64 = 6_378_137.0;
/// WGS 84's flattening.
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Scale of UTM on its central meridian.
const UTM_SCALE: f64 = 0.9996;

/// β₁ to β₆ of equation 36, whole numbers over whole numbers, by powers of the third flattening.
fn betas(n: f64) -> [f64; 6] {
    // Horner's scheme: the coefficients of the lowest power first.
    let series = |terms: &[f64]| terms.iter().rev().fold(0.0, |sum, term| sum * n + term);
    [
        series(&[0.0, 1. / 2., -2. / 3., 37. / 96., -1. / 360., -81. / 512., 96_199. / 604_800.]),
        series(&[0.0, 0.0, 1. / 48., 1. / 15., -437. / 1440., 46. / 105., -1_118_711. / 3_870_720.]),
        series(&[0.0, 0.0, 0.0, 17. / 480., -37. / 840., -209. / 4480., 5569. / 90_720.]),
        series(&[0.0, 0.0, 0.0, 0.0, 4397. / 161_280., -11. / 504., -830_251. / 7_257_600.]),
        series(&[0.0, 0.0, 0.0, 0.0, 0.0, 4583. / 161_280., -108_847. / 3_991_680.]),
        series(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 20_648_693. / 638_668_800.]),
    ]
}

/// Longitude and latitude in degrees of an easting and a northing in metres of the UTM zone 1 to 60; `south`: of the
/// southern half, whose northings count from ten million.
pub(super) fn from_utm(easting: f64, northing: f64, zone: u32, south: bool) -> [f64; 2] {
    let n = FLATTENING / (2.0 - FLATTENING);
    // The meridian's length over 2π: equation 14.
    let rectifying = RADIUS / (1.0 + n) * (1.0 + n * n / 4.0 + n.powi(4) / 64.0 + n.powi(6) / 256.0);
    let scale = UTM_SCALE * rectifying;
    let xi = if south { northing - 10_000_000.0 } else { northing } / scale;
    let eta = (easting - 500_000.0) / scale;
    let (mut sphere_xi, mut sphere_eta) = (xi, eta);
    for (beta, twice) in betas(n).into_iter().zip((1..).map(|order| 2.0 * f64::from(order))) {
        sphere_xi -= beta * (twice * xi).sin() * (twice * eta).cosh();
        sphere_eta -= beta * (twice * xi).cos() * (twice * eta).sinh();
    }
    let longitude = sphere_eta.sinh().atan2(sphere_xi.cos());
    let conformal = sphere_xi.sin() / sphere_eta.sinh().hypot(sphere_xi.cos());
    [f64::from(zone) * 6.0 - 183.0 + longitude.to_degrees(), latitude_tangent(conformal).atan().to_degrees()]
}

/// The tangent of the latitude from that of the conformal latitude, by Newton's method (equations 19 to 21).
fn latitude_tangent(conformal: f64) -> f64 {
    let e2 = FLATTENING * (2.0 - FLATTENING);
    let e = e2.sqrt();
    let mut tangent = conformal;
    for _ in 0..6 {
        let root = (1.0 + tangent * tangent).sqrt();
        let sigma = (e * (e * tangent / root).atanh()).sinh();
        let there = tangent * (1.0 + sigma * sigma).sqrt() - sigma * root;
        let step = (conformal - there) / (1.0 + there * there).sqrt() * (1.0 + (1.0 - e2) * tangent * tangent)
            / ((1.0 - e2) * root);
        tangent += step;
        if step.abs() < 1e-16 * (1.0 + tangent.abs()) {
            break;
        }
    }
    tangent
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against PROJ 9 (`pyproj`, EPSG:326zz and EPSG:327zz to EPSG:4326): a thousand millionth of a degree is a tenth of a
    /// millimetre. Among them the foot of a zone's meridian, the equator at a zone's edge, 400 km beside a zone's
    /// meridian, the far north.
    #[test]
    fn it_agrees_with_proj() {
        let known = [
            (11, false, [250_000.0, 3_900_000.0], [-119.746_421_250_254_7, 35.211_910_798_187_034]),
            (19, true, [700_000.0, 7_500_000.0], [-67.054_449_779_880_94, -22.595_067_595_103_338]),
            (32, false, [500_000.0, 0.0], [9.0, 0.0]),
            (33, false, [900_000.0, 6_700_000.0], [22.233_285_956_637_832, 60.239_081_911_018_07]),
            (1, false, [166_021.443, 0.0], [-180.000_000_000_722_83, 0.0]),
            (60, false, [600_000.0, 9_000_000.0], [182.745_516_762_487_88, 81.016_474_270_286_5]),
        ];
        for (zone, south, [x, y], expected) in known {
            let got = from_utm(x, y, zone, south);
            let off = (got[0] - expected[0]).abs().max((got[1] - expected[1]).abs());
            assert!(off < 1e-9, "{got:?} for {expected:?} in zone {zone}");
        }
    }
}
