use std::sync::Arc;
fn main() {
    let gpu = relief::gpu::Gpu::headless().unwrap();
    let args: Vec<String> = std::env::args().collect();
    // MAP then pairs scene out
    let map = Arc::new(relief::heightfield::load::load(std::path::Path::new(&args[1])).unwrap().field);
    let mut r = relief::render::Renderer::new(Arc::clone(&gpu)).unwrap();
    r.set_terrain(map).unwrap();
    for pair in args[2..].chunks(2) {
        let scene = relief::scene_file::read(std::path::Path::new(&pair[0])).unwrap();
        let target = relief::gpu::Target::new(&gpu, [640, 400]);
        r.draw(&scene, &target).unwrap();
        r.reload_shaders().unwrap();
        r.draw(&scene, &target).unwrap();
        let mut ts = vec![];
        for _ in 0..7 {
            r.draw(&scene, &target).unwrap();
            ts.push(r.wait_frame_time().unwrap());
        }
        ts.sort_by(f64::total_cmp);
        println!("{} {:.1} ms {:?} {:?}", pair[1], ts[3], r.ledger().passes, r.ledger().shader_defs.len());
        target.read_color(&gpu).unwrap().save(&pair[1]).unwrap();
    }
}
