//! How rays meet the height field.

use egui::Ui;

use super::Panel;
use super::widgets::{Choice, Number, choose, section, toggle};
use crate::scene::{DetailSettings, HeightFilter, MarchSettings, Technique};

const EXACT: &str = "the technique finds the surface itself and takes no samples";

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Sets technique, samples and options back to their defaults. Rebuilds a pipeline on first use.";
    section(ui, "March", true, Some(reset), |ui, reset| {
        let compared = panel.scene.compare.enabled.then_some(panel.scene.compare.technique);
        let march = &mut panel.scene.march;
        if reset {
            *march = MarchSettings::default();
            panel.scene.detail = DetailSettings::default();
        }
        technique(ui, march);
        // Both halves of a split picture take the same settings.
        let drawn: Vec<_> = std::iter::once(march.technique).chain(compared).collect();
        samples(ui, march, &drawn);
        filter(ui, march, &drawn, panel.facts.filterable_heights);
        let invents = drawn.contains(&Technique::Fractal);
        let tooltip = "Heights of what fractal invents, over those that go on as the map leaves off. 0 is none. Higher ones take longer.";
        Number::new("Detail strength", tooltip)
            .disabled_when(!invents, "only the technique fractal invents detail")
            .slider(ui, &mut panel.scene.detail.strength, 0.0..=4.0);
        let tooltip = "Rays start at the height of the highest terrain and not at the lid of the box. Saves steps.";
        toggle(ui, &mut march.lower_start, "Lower start", tooltip);
        let tooltip = "Rays that meet nothing are discarded, which gives the terrain its silhouette; otherwise they \
                       show the ground's colour where they leave the box. Free.";
        toggle(ui, &mut march.discard_misses, "Discard misses", tooltip);
    });
}

fn technique(ui: &mut Ui, march: &mut MarchSettings) {
    let choices = Technique::CHOICES.map(|value| Choice {
        value,
        name: value.name(),
        off: None,
        tooltip: match value {
            Technique::Linear => "Uniform steps between entering and leaving the box. Wrong by up to a step.",
            Technique::LinearBinary => {
                "Uniform steps, then halvings of the last one. Misses what is thinner than a step."
            }
            Technique::Secant => {
                "Uniform steps; the ground in the last one is taken for a straight line. Misses what is thinner than a step."
            }
            Technique::Cone => {
                "Steps as long as a cone without ground allows, then halvings. The cones are found in the \
                 background, for seconds, and again after a crater; until then max-mipmap draws."
            }
            Technique::RelaxedCone => {
                "Steps as long as a cone allows whose ground a ray enters only once, then halvings. Its cones take longer to find; \
                 until then max-mipmap draws."
            }
            Technique::MaxMipmap => "Exact: skips along a pyramid of maxima and meets the bilinear surface itself.",
            Technique::Smooth => {
                "Another surface: rounded between the samples, without the creases of the bilinear one. Takes longer in each \
                 cell that a ray comes near, and a map without holes. Shadows, the probe and contours are those of the bilinear one."
            }
            Technique::Fractal => {
                "Ground with invented detail: between the samples, which stay as they are, and near the eye, noise as rough as the \
                 map. Takes several times as long near the eye, and a map without holes."
            }
        },
    });
    let tooltip = "How a ray finds the ground. Each technique is a pipeline of its own, built on first use.";
    choose(ui, &mut march.technique, &choices, "Technique", tooltip, None);
}

fn samples(ui: &mut Ui, march: &mut MarchSettings, drawn: &[Technique]) {
    let exact = !drawn.iter().any(|technique| technique.counts_samples());
    let solved = !drawn.iter().any(|technique| technique.halves());
    let fixed = !exact && !march.steps_by_angle;
    let tooltip = "Steps of a ray that looks straight down. More are slower and miss less.";
    let fewest = Number::new("Fewest samples", tooltip).logarithmic();
    fewest
        .disabled_when(fixed, "every ray takes the most samples unless their number depends on the angle")
        .disabled_when(exact, EXACT)
        .slider(ui, &mut march.samples_min, 1..=4096);
    // Whichever is moved pushes the other along: a scene with fewer most than fewest samples is refused.
    march.samples_max = march.samples_max.max(march.samples_min);
    let tooltip = "Steps of a horizontal ray, or of every ray without steps by angle. Time grows with it.";
    let most = Number::new("Most samples", tooltip).logarithmic();
    most.disabled_when(exact, EXACT).slider(ui, &mut march.samples_max, 1..=4096);
    march.samples_min = march.samples_min.min(march.samples_max);
    ui.add_enabled_ui(!exact, |ui| {
        let tooltip = "Steep rays take fewer steps than flat ones. Saves time where it is safe.";
        let box_ = ui.checkbox(&mut march.steps_by_angle, "Steps by angle").on_hover_text(tooltip);
        box_.on_disabled_hover_text(format!("{tooltip}\n\nNot in use: {EXACT}"));
    });
    let tooltip =
        "Halvings of the step that went below the ground; 0 is off. Each costs one sample and halves the error.";
    Number::new("Halvings", tooltip)
        .disabled_when(solved && drawn.contains(&Technique::Linear), "linear takes the first sample below the ground")
        .disabled_when(solved && drawn.contains(&Technique::Secant), "secant solves the last step as a straight line")
        .disabled_when(exact, EXACT)
        .slider(ui, &mut march.binary_steps, 0..=24);
}

fn filter(ui: &mut Ui, march: &mut MarchSettings, drawn: &[Technique], hardware: bool) {
    let unfiltered = (!hardware).then_some("this adapter cannot filter the map's heights");
    let choices = [
        Choice {
            value: HeightFilter::Exact,
            name: "exact",
            tooltip: "The four corners, interpolated in 32 bits: the surface itself. The slowest of the three.",
            off: None,
        },
        Choice {
            value: HeightFilter::HardwareLinear,
            name: "hardware-linear",
            tooltip: "The sampler's filter: fast, but its weights have 8 bits, which shows as stairs near the eye.",
            off: unfiltered,
        },
        Choice {
            value: HeightFilter::Nearest,
            name: "nearest",
            tooltip: "The nearest sample: a field of boxes. The fastest.",
            off: None,
        },
    ];
    let off = if drawn.iter().any(|technique| technique.samples_uniformly()) {
        None
    } else if drawn.iter().any(|technique| technique.cones().is_some()) {
        Some("cones are only safe over the surface itself")
    } else {
        Some(EXACT)
    };
    let tooltip = "How a height between the samples of the map is read.";
    choose(ui, &mut march.filter, &choices, "Height filter", tooltip, off);
}
