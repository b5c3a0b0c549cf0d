//! Nothing hangs a GPU, and nothing is read out of bounds: read from the compiled modules of every reachable variant.
//!
//! A loop is bounded where its guard lets it go on only while a counter is below a number that a constant bounds, and
//! each turn raises the counter. A load is in bounds where its coordinate ends in a `clamp` or `min` with the size of its
//! texture. Everything else goes through a sampler, whose address mode bounds it.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use naga::{
    BinaryOperator, Block, Expression, Function, Handle, ImageQuery, Literal, LocalVariable, MathFunction, Module,
    Statement,
};

use super::terrain_uniform;
use crate::heightfield::load::MAX_SIDE;
use crate::scene_file::{MOST_HALVINGS, MOST_SAMPLES, MOST_STEPS};

/// A variable, or a member of one.
type Place = (Handle<LocalVariable>, Option<u32>);

type Value = Handle<Expression>;

/// A function of a module.
struct Code<'a> {
    module: &'a Module,
    function: &'a Function,
}

/// What a loop's guard says.
#[derive(Debug)]
struct Guard {
    counter: Place,
    bound: f64,
}

impl Code<'_> {
    fn expression(&self, value: Value) -> &Expression {
        &self.function.expressions[value]
    }

    /// The most that a number can be, where a constant says it.
    fn most(&self, value: Value) -> Option<f64> {
        match *self.expression(value) {
            Expression::Literal(literal) => number(literal),
            Expression::Constant(constant) => {
                match self.module.global_expressions[self.module.constants[constant].init] {
                    Expression::Literal(literal) => number(literal),
                    _ => None,
                }
            }
            Expression::Binary { op: BinaryOperator::Add, left, right } => Some(self.most(left)? + self.most(right)?),
            Expression::Math { fun: MathFunction::Min, arg, arg1: Some(other), .. } => {
                [self.most(arg), self.most(other)].into_iter().flatten().reduce(f64::min)
            }
            Expression::Math { fun: MathFunction::Clamp, arg2: Some(high), .. } => self.most(high),
            // What it returns, whichever way.
            Expression::CallResult(function) => {
                let called = Code { module: self.module, function: &self.module.functions[function] };
                let mut returned = Vec::new();
                each(&called.function.body, &mut |statement| {
                    if let Statement::Return { value: Some(value) } = statement {
                        returned.push(called.most(*value));
                    }
                });
                returned.into_iter().collect::<Option<Vec<_>>>()?.into_iter().reduce(f64::max)
            }
            _ => None,
        }
    }

    fn place(&self, pointer: Value) -> Option<Place> {
        match *self.expression(pointer) {
            Expression::LocalVariable(variable) => Some((variable, None)),
            Expression::AccessIndex { base, index } => match *self.expression(base) {
                Expression::LocalVariable(variable) => Some((variable, Some(index))),
                _ => None,
            },
            _ => None,
        }
    }

    /// The place that a value was loaded from.
    fn loaded(&self, value: Value) -> Option<Place> {
        match *self.expression(value) {
            Expression::Load { pointer } => self.place(pointer),
            _ => None,
        }
    }

    /// The comparisons with a constant in a condition that all have to hold for the loop to go on.
    fn bounding(&self, condition: Value) -> Vec<Guard> {
        match *self.expression(condition) {
            Expression::Binary { op: BinaryOperator::And | BinaryOperator::LogicalAnd, left, right } => {
                [self.bounding(left), self.bounding(right)].into_iter().flatten().collect()
            }
            Expression::Binary { op: BinaryOperator::Less | BinaryOperator::LessEqual, left, right } => {
                let guard = || Some(Guard { counter: self.loaded(left)?, bound: self.most(right)? });
                guard().into_iter().collect()
            }
            _ => Vec::new(),
        }
    }

    /// The guards with which a loop's body begins: `if condition {} else { break; }`.
    fn guards(&self, body: &Block) -> Vec<Guard> {
        let first = body.iter().find(|statement| !matches!(statement, Statement::Emit(_)));
        match first {
            Some(Statement::If { condition, accept, reject })
                if accept.is_empty() && matches!(reject[..], [Statement::Break]) =>
            {
                self.bounding(*condition)
            }
            _ => Vec::new(),
        }
    }

    /// Whether a store raises what is in `place` by one or more.
    fn raises(&self, place: Place, pointer: Value, value: Value) -> bool {
        let Expression::Binary { op: BinaryOperator::Add, left, right } = *self.expression(value) else { return false };
        let step = match *self.expression(right) {
            Expression::Literal(literal) => number(literal),
            _ => None,
        };
        self.place(pointer) == Some(place) && self.loaded(left) == Some(place) && step.is_some_and(|step| step >= 1.0)
    }

    /// The load through which the `member` of a value comes unchanged from the variable itself.
    fn origin(&self, value: Value, variable: Handle<LocalVariable>, member: u32) -> Option<Value> {
        match *self.expression(value) {
            Expression::Load { pointer } => (self.place(pointer)? == (variable, None)).then_some(value),
            Expression::Compose { ref components, .. } => {
                let component = *components.get(member as usize)?;
                match *self.expression(component) {
                    Expression::AccessIndex { base, index } if index == member => self.origin(base, variable, member),
                    _ => (self.loaded(component)? == (variable, Some(member))).then_some(component),
                }
            }
            Expression::CallResult(function) => {
                let called = Code { module: self.module, function: &self.module.functions[function] };
                let mut arguments = None;
                each(&self.function.body, &mut |statement| {
                    if let Statement::Call { result, arguments: given, .. } = statement
                        && *result == Some(value)
                    {
                        arguments = Some(given.clone());
                    }
                });
                let mut sources = BTreeSet::new();
                each(&called.function.body, &mut |statement| {
                    if let Statement::Return { value: Some(value) } = statement {
                        sources.insert(called.argument_of(*value, member));
                    }
                });
                match sources.into_iter().collect::<Vec<_>>()[..] {
                    [Some(argument)] => self.origin(arguments?[argument as usize], variable, member),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// The argument of this function whose `member` is that of the value.
    fn argument_of(&self, value: Value, member: u32) -> Option<u32> {
        let Expression::Compose { ref components, .. } = *self.expression(value) else { return None };
        let Expression::AccessIndex { base, index } = *self.expression(*components.get(member as usize)?) else {
            return None;
        };
        match *self.expression(base) {
            Expression::FunctionArgument(argument) if index == member => Some(argument),
            _ => None,
        }
    }

    /// Why a loop might not end.
    fn doubt(&self, body: &Block, continuing: &Block) -> Option<String> {
        let doubts: Vec<_> = self.guards(body).iter().map(|guard| self.doubt_of(guard, [body, continuing])).collect();
        match doubts.iter().position(Option::is_none) {
            Some(_) => None,
            None => Some(doubts.into_iter().flatten().next().unwrap_or_else(|| {
                "it does not begin with a comparison of a counter with a number that a constant bounds".into()
            })),
        }
    }

    fn doubt_of(&self, guard: &Guard, blocks: [&Block; 2]) -> Option<String> {
        if guard.bound > f64::from(MOST_STEPS) {
            return Some(format!("{} turns", guard.bound));
        }
        let (variable, member) = guard.counter;
        let raised = blocks.into_iter().flat_map(always).find_map(|statement| match *statement {
            Statement::Store { pointer, value } if self.raises(guard.counter, pointer, value) => Some(value),
            _ => None,
        });
        let Some(raised) = raised else { return Some("not every turn raises the counter".into()) };
        let mut doubt = None;
        for block in blocks {
            each(block, &mut |statement| match *statement {
                Statement::Continue => doubt = Some("it may go on before the counter was raised".to_owned()),
                Statement::Store { pointer, value } => {
                    let place = self.place(pointer);
                    let touches = place == Some(guard.counter) || place == Some((variable, None));
                    if touches && !self.raises(guard.counter, pointer, value) {
                        let origin = member.and_then(|member| self.origin(value, variable, member));
                        // Loaded and stored on the same side of the step, or the step would be lost.
                        let kept = origin.is_some_and(|origin| (origin < raised) == (value < raised));
                        if !kept {
                            doubt = Some("something else writes to the counter".to_owned());
                        }
                    }
                }
                _ => {}
            });
        }
        doubt
    }

    /// Why a load might be out of bounds.
    fn load_doubt(&self, image: Value, coordinate: Value) -> Option<String> {
        let limit = match *self.expression(coordinate) {
            Expression::Math { fun: MathFunction::Min, arg1, .. } => arg1,
            Expression::Math { fun: MathFunction::Clamp, arg2, .. } => arg2,
            _ => None,
        };
        let Some(limit) = limit else { return Some("its coordinate is not clamped".into()) };
        // How much less than the texture's size the limit is, on the way to what says that size.
        let (mut part, mut less) = (limit, 0.0);
        let beyond = loop {
            match *self.expression(part) {
                Expression::As { expr, .. } | Expression::Load { pointer: expr } => part = expr,
                Expression::Binary { op: BinaryOperator::Subtract, left, right } => {
                    less += self.everywhere(right).unwrap_or(f64::NEG_INFINITY);
                    part = left;
                }
                Expression::ImageQuery { image: other, query: ImageQuery::Size { .. } } => {
                    break if self.expression(other) == self.expression(image) { less < 1.0 } else { true };
                }
                // `terrain.cells`: the size of the cones' texture, and one less than that of the heights'.
                Expression::AccessIndex { base, index } if self.names_cells(base, index) => {
                    break less < if self.is_named(image, "heights") { 0.0 } else { 1.0 };
                }
                _ => break true,
            }
        };
        beyond.then(|| "its coordinate is not clamped to the last texel of its texture".into())
    }

    /// The number that each component of a value is.
    fn everywhere(&self, value: Value) -> Option<f64> {
        match *self.expression(value) {
            Expression::Literal(literal) => number(literal),
            Expression::Splat { value, .. } => self.everywhere(value),
            _ => None,
        }
    }

    fn is_named(&self, image: Value, name: &str) -> bool {
        let Expression::GlobalVariable(global) = *self.expression(image) else { return false };
        self.module.global_variables[global].name.as_deref().is_some_and(|full| full.starts_with(name))
    }

    fn names_cells(&self, base: Value, index: u32) -> bool {
        let Expression::GlobalVariable(global) = *self.expression(base) else { return false };
        let ty = &self.module.types[self.module.global_variables[global].ty].inner;
        let naga::TypeInner::Struct { members, .. } = ty else { return false };
        members[index as usize].name.as_deref() == Some("cells")
    }
}

fn number(literal: Literal) -> Option<f64> {
    match literal {
        Literal::F32(value) => Some(f64::from(value)),
        Literal::U32(value) => Some(f64::from(value)),
        Literal::I32(value) => Some(f64::from(value)),
        _ => None,
    }
}

/// The statements that a block runs through, whatever happens in it.
fn always(block: &Block) -> Vec<&Statement> {
    let mut statements = Vec::new();
    for statement in block {
        match statement {
            Statement::Block(block) => statements.extend(always(block)),
            other => statements.push(other),
        }
    }
    statements
}

/// Every statement of a block and of the blocks in it.
fn each(block: &Block, visit: &mut dyn FnMut(&Statement)) {
    for statement in block {
        visit(statement);
        match statement {
            Statement::Block(block) => each(block, visit),
            Statement::If { accept, reject, .. } => {
                each(accept, visit);
                each(reject, visit);
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| each(&case.body, visit)),
            Statement::Loop { body, continuing, .. } => {
                each(body, visit);
                each(continuing, visit);
            }
            _ => {}
        }
    }
}

/// Loops and loads of a module, and what is doubtful about them.
#[derive(Default, Debug)]
struct Findings {
    loops: usize,
    loads: usize,
    doubts: BTreeSet<String>,
}

fn examine(module: &Module) -> Findings {
    let mut findings = Findings::default();
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    for function in module.functions.iter().map(|(_, function)| function).chain(entries) {
        let code = Code { module, function };
        let name = function.name.clone().unwrap_or_default();
        each(&function.body, &mut |statement| {
            if let Statement::Loop { body, continuing, .. } = statement {
                findings.loops += 1;
                findings.doubts.extend(code.doubt(body, continuing).map(|doubt| format!("a loop of {name}: {doubt}")));
            }
        });
        for (_, expression) in function.expressions.iter() {
            if let Expression::ImageLoad { image, coordinate, .. } = *expression {
                findings.loads += 1;
                let doubt = code.load_doubt(image, coordinate);
                findings.doubts.extend(doubt.map(|doubt| format!("a load of {name}: {doubt}")));
            }
        }
    }
    findings
}

/// Looks at a module before a pipeline is made of it. Every pipeline that a test builds goes through here, and one test
/// builds all that a scene can lead to.
///
/// # Panics
/// Where a loop might not end or a load be out of bounds.
pub(super) fn examine_or_panic(pass: &str, module: &Module) {
    let findings = examine(module);
    assert!(findings.doubts.is_empty(), "{pass}: {:#?}", findings.doubts);
    LOOPS.fetch_add(findings.loops, Relaxed);
    LOADS.fetch_add(findings.loads, Relaxed);
}

/// Loops and loads that were found to be bounded so far.
pub(super) fn bounded() -> [usize; 2] {
    [LOOPS.load(Relaxed), LOADS.load(Relaxed)]
}

static LOOPS: AtomicUsize = AtomicUsize::new(0);
static LOADS: AtomicUsize = AtomicUsize::new(0);

/// It would see nothing with eyes shut.
#[test]
fn loops_without_a_bound_are_found() {
    let doubts = |body: &str| {
        let source = format!(
            "const MOST: u32 = 9u; struct S {{ t: f32, n: u32 }} @group(0) @binding(0) var<uniform> u: vec2u;
            @group(0) @binding(1) var image: texture_2d<f32>;
            fn other(s: S) -> S {{ return S(s.t, 0u); }} fn same(t: f32, s: S) -> S {{ return S(t, s.n); }}
            @fragment fn main(@builtin(position) p: vec4f) -> @location(0) vec4f {{
                var s = S(0.0, 0u); var sum = 0.0; {body} return vec4f(sum + s.t); }}"
        );
        examine(&naga::front::wgsl::parse_str(&source).unwrap()).doubts.len()
    };
    for bounded in [
        "for (var i = 0u; i < 8u; i++) { sum += 1.0; }",
        "for (var i = 0u; i < min(u.x, MOST); i += 1u) { sum += 1.0; }",
        "let m = min(u.x, MOST); while (s.t < 5.0) & (s.n < m) { s.n += 1u; s = same(2.0, s); }",
        "while s.n < MOST { s.n += 1u; if sum > 3.0 { s = S(1.0, s.n); } }",
        "sum = textureLoad(image, min(vec2i(p.xy), vec2i(textureDimensions(image)) - 1), 0).r;",
    ] {
        assert_eq!(doubts(bounded), 0, "{bounded}");
    }
    for endless in [
        "loop { sum += 1.0; if sum > 5.0 { break; } }",
        "for (var i = 0u; i < u.x; i++) { sum += 1.0; }",
        "for (var i = 0u; i < min(u.x, u.y); i++) { sum += 1.0; }",
        "for (var i = 0u; i < MOST; i += 0u) { sum += 1.0; }",
        "for (var i = 0u; i < MOST; i++) { if sum > 3.0 { i = 0u; } sum += 1.0; }",
        "for (var i = 0u; i < 4000000000u; i++) { sum += 1.0; }",
        "while s.n < MOST { if sum > 2.0 { s.n += 1u; } sum += 1.0; }",
        "while s.n < MOST { s.n += 1u; s = other(s); }",
        "while s.n < MOST { let old = s; s.n += 1u; s = same(1.0, old); }",
        "sum = textureLoad(image, vec2i(p.xy), 0).r;",
        "sum = textureLoad(image, min(vec2i(p.xy), vec2i(u)), 0).r;",
        "sum = textureLoad(image, min(vec2i(p.xy), vec2i(textureDimensions(image))), 0).r;",
        "sum = textureLoad(image, min(vec2i(p.xy), vec2i(textureDimensions(image)) - 0), 0).r;",
    ] {
        assert_eq!(doubts(endless), 1, "{endless}");
    }
}

/// The constants are no tighter than what is asked for.
#[test]
fn the_constants_hold_what_scenes_and_maps_ask_for() {
    let mut scene = crate::scene::Scene::default();
    (scene.march.samples_min, scene.march.samples_max) = (MOST_SAMPLES, MOST_SAMPLES);
    scene.march.binary_steps = MOST_HALVINGS;
    assert_eq!(crate::scene_file::validate(&scene), Ok(()));
    assert_eq!(terrain_uniform::step_cap([MAX_SIDE - 1, MAX_SIDE - 1]).max(MOST_STEPS), MOST_STEPS);
}
