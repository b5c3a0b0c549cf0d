//! Where the sun stands, from date, time and place.
//!
//! The low-accuracy theory of Meeus, Astronomical Algorithms (2nd edition, 1998), chapter 25, as the NOAA solar calculator
//! uses it, too: good to 0.01° between 1900 and 2100. Refraction by chapter 16 (Sæmundsson 1986), at 10 °C and 1010 hPa.

/// A sun's apparent place over the horizon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPlace {
    /// Clockwise from north, degrees, 0 to 360.
    pub azimuth: f64,
    /// Over the horizon, degrees, with refraction.
    pub elevation: f64,
}

/// Days of a month, 1 to 12, of the Gregorian calendar.
pub fn days_in_month(year: i32, month: u32) -> u32 {
    match month {
        2 if year % 4 == 0 && (year % 100 != 0 || year % 400 == 0) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days from noon of 1 January 4713 BC (Julian) to `hour` UTC of a day of the Gregorian calendar; the hour may lie outside
/// of the day. Meeus, chapter 7.
pub fn julian_day(year: i32, month: u32, day: u32, hour: f64) -> f64 {
    let (year, month) = if month <= 2 { (year - 1, month + 12) } else { (year, month) };
    let century = (f64::from(year) / 100.0).floor();
    let leap = 2.0 - century + (century / 4.0).floor();
    (365.25 * f64::from(year + 4716)).floor() + (30.6001 * f64::from(month + 1)).floor() + f64::from(day) + leap
        - 1524.5
        + hour / 24.0
}

/// Apparent right ascension and declination of the sun, degrees. Meeus, chapter 25.
pub fn equatorial(julian_day: f64) -> [f64; 2] {
    let t = (julian_day - 2_451_545.0) / 36_525.0;
    let sin = |degrees: f64| degrees.to_radians().sin();
    let mean_longitude = 280.466_46 + t * (36_000.769_83 + t * 0.000_303_2);
    let anomaly = 357.529_11 + t * (35_999.050_29 - t * 0.000_153_7);
    let centre = sin(anomaly) * (1.914_602 - t * (0.004_817 + t * 0.000_014))
        + sin(2.0 * anomaly) * (0.019_993 - t * 0.000_101)
        + sin(3.0 * anomaly) * 0.000_289;
    let node = 125.04 - 1_934.136 * t;
    let longitude = (mean_longitude + centre - 0.005_69 - 0.004_78 * sin(node)).to_radians();
    let obliquity = 23.439_291 - t * (0.013_004_2 + t * (1.6e-7 - t * 5.04e-7)) + 0.002_56 * node.to_radians().cos();
    let (sin_tilt, cos_tilt) = obliquity.to_radians().sin_cos();
    let ascension = (cos_tilt * longitude.sin()).atan2(longitude.cos());
    [ascension.to_degrees().rem_euclid(360.0), (sin_tilt * longitude.sin()).asin().to_degrees()]
}

/// Where the sun is seen from `latitude` north and `longitude` east, degrees.
pub fn place(julian_day: f64, latitude: f64, longitude: f64) -> SunPlace {
    let [ascension, declination] = equatorial(julian_day);
    let days = julian_day - 2_451_545.0;
    let century = days / 36_525.0;
    // Mean sidereal time at Greenwich, Meeus (12.4).
    let sidereal = 280.460_618_37 + 360.985_647_366_29 * days + 0.000_387_933 * century * century;
    let (sin_hour, cos_hour) = (sidereal + longitude - ascension).to_radians().sin_cos();
    let (sin_north, cos_north) = latitude.to_radians().sin_cos();
    let (sin_sun, cos_sun) = declination.to_radians().sin_cos();
    let height = (sin_north * sin_sun + cos_north * cos_sun * cos_hour).clamp(-1.0, 1.0).asin().to_degrees();
    let azimuth = (-cos_sun * sin_hour).atan2(sin_sun * cos_north - cos_sun * sin_north * cos_hour);
    SunPlace { azimuth: azimuth.to_degrees().rem_euclid(360.0), elevation: height + refraction(height) }
}

/// How much higher than it stands the sun is seen, degrees. Meeus (16.4); less and less where it has set.
fn refraction(height: f64) -> f64 {
    let seen = height.max(-1.0);
    let arcminutes = 1.02 / (seen + 10.3 / (seen + 5.11)).to_radians().tan();
    arcminutes.max(0.0) / 60.0 * (1.0 + (height + 1.0).min(0.0) / 4.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(value: f64, published: f64, tolerance: f64) {
        assert!((value - published).abs() < tolerance, "{value} is not {published}");
    }

    #[test]
    fn days_are_those_of_meeus() {
        // Chapter 7, table of test values, and example 7.a.
        close(julian_day(2000, 1, 1, 12.0), 2_451_545.0, 1e-9);
        close(julian_day(1957, 10, 4, 0.81 * 24.0), 2_436_116.31, 1e-6);
        close(julian_day(1988, 6, 19, 12.0), 2_447_332.0, 1e-9);
        close(julian_day(1600, 12, 31, 0.0), 2_305_812.5, 1e-9);
    }

    #[test]
    fn the_sun_stands_where_it_was_published() {
        // Meeus, example 25.a: 1992 October 13, 0h TD.
        let [ascension, declination] = equatorial(julian_day(1992, 10, 13, 0.0));
        close(ascension, 198.380_83, 0.001);
        close(declination, -7.785_07, 0.001);
        // Reda and Andreas 2004, NREL/TP-560-34302, table A5.1: 2003 October 17, 12:30:30 at UTC − 7, Golden, Colorado.
        let sun = place(julian_day(2003, 10, 17, 19.0 + 30.5 / 60.0), 39.742_476, -105.178_6);
        close(sun.elevation, 90.0 - 50.111_62, 0.02);
        close(sun.azimuth, 194.340_24, 0.02);
    }

    #[test]
    fn noon_is_south_in_the_north_and_north_in_the_south() {
        let noon = julian_day(2026, 3, 20, 12.1);
        close(place(noon, 50.0, 0.0).azimuth, 180.0, 1.5);
        close(place(noon, -50.0, 0.0).azimuth.rem_euclid(360.0), 0.0, 1.5);
        // Between the tropics at an equinox it stands overhead.
        assert!(place(noon, 0.0, 0.0).elevation > 89.0);
        assert!(place(julian_day(2026, 3, 20, 0.0), 50.0, 0.0).elevation < -30.0, "midnight");
        // Seen on the horizon it has set already, by half a degree: refraction there is 34' at sea level.
        close(refraction(-0.575), 0.567, 0.05);
    }
}
