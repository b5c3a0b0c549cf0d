//! The event loop: hands what the window system sends to the viewer, and asks to be called again only when a frame is
//! due.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use egui_winit::accesskit_winit;
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalSize};
use winit::event::{DeviceEvent, DeviceId, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

use super::desktop::Wishes;
use super::files::FilesEvent;
use super::frame::FrameError;
use super::graphics::Graphics;
use super::keeping::{self, Keeper};
use super::preferences::Store;
use super::redraw::Next;
use super::viewer::Viewer;
use super::{AppError, ViewerOptions};

/// The window's inside where no size is given, points.
const SIZE: LogicalSize<u32> = LogicalSize::new(1280, 800);

/// What other threads tell the event loop.
#[derive(Debug)]
pub(crate) enum UserEvent {
    /// A screen reader wants something.
    Accessibility(accesskit_winit::Event),
    /// A height map was opened, or could not be.
    Loaded,
    /// A dialogue ended, or a map was saved.
    Files(FilesEvent),
    /// Distances of the reference were found.
    Reference,
    /// Cones were found, or the search for them has ended otherwise.
    Cones,
    /// Pipelines were compiled, or do not compile.
    Compiled,
    /// A shader was saved.
    ShadersChanged,
    /// The desktop has answered what it asks of programs.
    Wishes(Wishes),
    /// A screenshot was written, or could not be.
    Screenshot(Result<PathBuf, String>),
}

impl From<accesskit_winit::Event> for UserEvent {
    fn from(event: accesskit_winit::Event) -> Self {
        Self::Accessibility(event)
    }
}

/// The application, before and after its window exists.
pub(crate) struct App {
    options: Option<ViewerOptions>,
    proxy: EventLoopProxy<UserEvent>,
    open: Option<(Viewer, Graphics)>,
    failure: Option<AppError>,
}

impl App {
    /// An application that opens its window once the event loop runs.
    pub(crate) fn new(options: ViewerOptions, proxy: EventLoopProxy<UserEvent>) -> Self {
        Self { options: Some(options), proxy, open: None, failure: None }
    }

    /// Why the event loop ended.
    pub(crate) fn into_result(self) -> Result<(), AppError> {
        self.failure.map_or(Ok(()), Err)
    }

    fn open(&self, event_loop: &ActiveEventLoop, options: ViewerOptions) -> Result<(Viewer, Graphics), AppError> {
        // Hidden until the accessibility adapter is there, which must come before the window shows.
        let attributes = Window::default_attributes().with_title("Relief").with_visible(false);
        let (store, kept, told) = Store::open(options.reset_settings);
        let attributes = match options.size {
            Some([width, height]) => attributes.with_inner_size(PhysicalSize::new(width, height)),
            None => keeping::placed(attributes.with_inner_size(SIZE), &kept.window, event_loop),
        };
        let window = event_loop.create_window(attributes).map_err(|error| AppError::Window(error.to_string()))?;
        let window = Arc::new(window);
        let graphics = Graphics::new(&window, options.map.clone(), kept.pace.vsync)?;
        let keeper = Keeper::new(store, kept, options.size);
        let mut viewer = Viewer::new(options, window.clone(), &graphics, event_loop, self.proxy.clone(), keeper);
        viewer.tell(&told);
        window.set_visible(true);
        window.request_redraw();
        Ok((viewer, graphics))
    }

    /// Ends the program with a message where `result` is one, and sets the device up again where it was lost.
    fn settle(&mut self, event_loop: &ActiveEventLoop, result: Result<(), FrameError>) {
        let failure = match result {
            Ok(()) => return,
            Err(FrameError::Fatal(error)) => error,
            Err(FrameError::Lost(lost)) => match self.recover(lost) {
                Ok(()) => return,
                Err(error) => error,
            },
        };
        self.failure = Some(failure);
        event_loop.exit();
    }

    /// A new device, surface and renderer for the same window. Once: a device that is lost again at once stays lost.
    fn recover(&mut self, lost: String) -> Result<(), AppError> {
        let Some((mut viewer, graphics)) = self.open.take() else { return Ok(()) };
        // The old surface has to let go of the window first.
        drop(graphics);
        if !viewer.may_recover(Instant::now()) {
            return Err(AppError::Lost { lost, again: "the new device was lost at once".into() });
        }
        let graphics = match Graphics::new(viewer.window(), viewer.map(), viewer.vsync()) {
            Ok(graphics) => graphics,
            Err(error) => return Err(AppError::Lost { lost, again: error.to_string() }),
        };
        viewer.recovered(&graphics, &lost);
        self.open = Some((viewer, graphics));
        Ok(())
    }
}

impl ApplicationHandler<UserEvent> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let Some(options) = self.options.take() else { return };
        match self.open(event_loop, options) {
            Ok(open) => self.open = Some(open),
            Err(error) => self.settle(event_loop, Err(FrameError::Fatal(error))),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _window: WindowId, event: WindowEvent) {
        let Some((viewer, graphics)) = &mut self.open else { return };
        let result = match event {
            WindowEvent::CloseRequested => {
                event_loop.exit();
                Ok(())
            }
            WindowEvent::RedrawRequested => viewer.frame(graphics, event_loop, Instant::now()),
            event => {
                viewer.window_event(graphics, &event, Instant::now());
                if viewer.wants_to_quit() {
                    event_loop.exit();
                }
                Ok(())
            }
        };
        self.settle(event_loop, result);
    }

    fn device_event(&mut self, _event_loop: &ActiveEventLoop, _device: DeviceId, event: DeviceEvent) {
        if let (Some((viewer, _)), DeviceEvent::MouseMotion { delta }) = (&mut self.open, event) {
            viewer.mouse_motion(delta.into());
        }
    }

    fn user_event(&mut self, _event_loop: &ActiveEventLoop, event: UserEvent) {
        if let Some((viewer, _)) = &mut self.open {
            viewer.user_event(event, Instant::now());
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some((viewer, graphics)) = &mut self.open else { return };
        let now = Instant::now();
        let result = viewer.poll(graphics, now);
        let control = match viewer.next(now) {
            Next::Now => {
                viewer.window().request_redraw();
                ControlFlow::Wait
            }
            Next::At(at) => ControlFlow::WaitUntil(at),
            Next::Never => ControlFlow::Wait,
        };
        let control = match (viewer.report(graphics, now), control) {
            (Some(due), ControlFlow::WaitUntil(at)) => ControlFlow::WaitUntil(due.min(at)),
            (Some(due), _) => ControlFlow::WaitUntil(due),
            (None, control) => control,
        };
        event_loop.set_control_flow(control);
        self.settle(event_loop, result);
    }

    fn exiting(&mut self, _event_loop: &ActiveEventLoop) {
        // The surface must go before the window, and both before the event loop.
        if let Some((mut viewer, graphics)) = self.open.take() {
            viewer.keep_now();
            viewer.finish_writing();
            drop(graphics);
            drop(viewer);
        }
    }
}
