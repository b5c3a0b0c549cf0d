//! What xdotool cannot do: look at the screen, and play the desktop around the viewer, which keeps the settings of all
//! programs and manages their windows.

use image::{Rgba, RgbaImage};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, CONFIGURE_NOTIFY_EVENT, ConfigureNotifyEvent, ConnectionExt, CreateWindowAux, EventMask, ImageFormat,
    PropMode, WindowClass,
};
use x11rb::rust_connection::RustConnection;

/// The pixels of a window that is on the screen as a whole.
pub(crate) fn screen(display: &str, window: u32) -> RgbaImage {
    let (connection, _) = RustConnection::connect(Some(display)).unwrap();
    let size = connection.get_geometry(window).unwrap().reply().unwrap();
    let image = connection.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, size.width, size.height, !0);
    let data = image.unwrap().reply().expect("the window is on the screen as a whole").data;
    let [width, height] = [size.width, size.height].map(u32::from);
    assert_eq!(data.len(), (4 * width * height) as usize, "four bytes a pixel");
    RgbaImage::from_fn(width, height, |x, y| {
        let at = 4 * (y * width + x) as usize;
        Rgba([data[at + 2], data[at + 1], data[at], 255])
    })
}

/// Another program's window over the upper left part of the screen; gone when dropped.
pub(crate) struct Cover {
    // The window lives as long as its connection.
    _connection: RustConnection,
}

impl Cover {
    pub(crate) fn new(display: &str, [width, height]: [u16; 2]) -> Self {
        let (connection, number) = RustConnection::connect(Some(display)).unwrap();
        let window = connection.generate_id().unwrap();
        let (root, class) = (connection.setup().roots[number].root, WindowClass::INPUT_OUTPUT);
        let settings = CreateWindowAux::new().override_redirect(1).background_pixel(0x0040_4040);
        connection.create_window(0, window, root, 0, 0, width, height, 0, class, 0, &settings).unwrap();
        connection.map_window(window).unwrap().check().unwrap();
        Self { _connection: connection }
    }
}

/// Minimises a window or brings it back, as window managers do.
pub(crate) fn minimise(display: &str, window: u32, minimised: bool) {
    let (connection, _) = RustConnection::connect(Some(display)).unwrap();
    let atom = |name: &str| connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
    let (state, hidden) = (atom("_NET_WM_STATE"), atom("_NET_WM_STATE_HIDDEN"));
    let bytes = hidden.to_ne_bytes();
    let (length, content): (u32, &[u8]) = if minimised { (1, &bytes) } else { (0, &[]) };
    let change = connection.change_property(PropMode::REPLACE, window, state, AtomEnum::ATOM, 32, length, content);
    change.unwrap().check().unwrap();
    let asked = if minimised { connection.unmap_window(window) } else { connection.map_window(window) };
    asked.unwrap().check().unwrap();
}

/// A desktop's settings, as its settings daemon publishes them (XSETTINGS). Has to be there before the viewer.
pub(crate) struct Settings {
    connection: RustConnection,
    owner: u32,
    property: u32,
}

impl Settings {
    /// Settings with a scale of 1.
    pub(crate) fn new(display: &str) -> Self {
        let (connection, number) = RustConnection::connect(Some(display)).unwrap();
        let atom = |name: &str| connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
        let (selection, property) = (atom(&format!("_XSETTINGS_S{number}")), atom("_XSETTINGS_SETTINGS"));
        let owner = connection.generate_id().unwrap();
        let (root, class) = (connection.setup().roots[number].root, WindowClass::INPUT_ONLY);
        connection.create_window(0, owner, root, -9, -9, 1, 1, 0, class, 0, &CreateWindowAux::new()).unwrap();
        connection.set_selection_owner(owner, selection, x11rb::CURRENT_TIME).unwrap();
        let settings = Self { connection, owner, property };
        settings.set_scale(1.0);
        settings
    }

    /// Publishes another scale, as the desktop does when its user chooses one.
    pub(crate) fn set_scale(&self, scale: f64) {
        // Byte order, serial number, and one setting: a number, its name, its serial number, 1024ths of a dot per inch.
        let mut bytes = vec![0; 8];
        bytes.extend(1u32.to_le_bytes());
        bytes.extend([0, 0]);
        bytes.extend(7u16.to_le_bytes());
        bytes.extend(b"Xft/DPI\0");
        bytes.extend(0u32.to_le_bytes());
        bytes.extend(((scale * 96.0 * 1024.0) as i32).to_le_bytes());
        let Self { connection, owner, property } = self;
        let length = bytes.len() as u32;
        // The property is its own type.
        let change = connection.change_property(PropMode::REPLACE, *owner, *property, *property, 8, length, &bytes);
        change.unwrap().check().unwrap();
    }

    /// Tells a window where it is, as window managers do after they have placed it.
    pub(crate) fn tell_place(&self, window: u32) {
        let size = self.connection.get_geometry(window).unwrap().reply().unwrap();
        let event = ConfigureNotifyEvent {
            response_type: CONFIGURE_NOTIFY_EVENT,
            sequence: 0,
            event: window,
            window,
            above_sibling: x11rb::NONE,
            x: size.x,
            y: size.y,
            width: size.width,
            height: size.height,
            border_width: 0,
            override_redirect: false,
        };
        self.connection.send_event(false, window, EventMask::STRUCTURE_NOTIFY, event).unwrap().check().unwrap();
    }
}
