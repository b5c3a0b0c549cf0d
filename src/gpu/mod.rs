//! The device and what it can do, targets and readback, timing, shader composition.

pub(crate) mod needs;
mod readback;
mod shaders;
mod target;
mod timing;

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

pub(crate) use readback::map_and_wait;
pub use readback::{ReadbackError, read_texture};
pub use shaders::{ShaderError, ShaderSources};
pub(crate) use target::{COLOR_BYTES_FORMAT, sized_texture};
pub use target::{COLOR_FORMAT, DEPTH_CLEAR, DEPTH_COMPARE, DEPTH_FORMAT, PROBE_FORMAT, Target};
pub use timing::FrameTimer;

/// Environment variable that narrows the choice of adapter: `cpu` takes a software driver, anything else is matched
/// against the adapter's name. wgpu's own `WGPU_*` variables are honoured besides.
pub const ADAPTER_VARIABLE: &str = "RELIEF_ADAPTER";

/// Environment variable that leaves the GPU's clock alone when it is `0`: times are then the wall's, as they are on an
/// adapter without timestamps. For drivers whose timestamps are wrong, and for tests.
pub const TIMESTAMPS_VARIABLE: &str = "RELIEF_TIMESTAMPS";

/// What a device offers beyond the baseline. Asked once, here; nothing in it is required.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capabilities {
    /// Frame times come from the GPU's clock rather than from the wall.
    pub timestamps: bool,
    /// Textures of 32-bit floats can be read through a linear filter.
    pub filterable_float32: bool,
    /// There are textures of 16-bit normalised integers: half the bytes for heights that 16 bits hold.
    pub unorm16: bool,
    /// Largest side of a texture.
    pub max_texture: u32,
    /// The adapter is a program that runs on the CPU: shaders are composed to suit it.
    pub software: bool,
}

/// Why there is no device.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// Adapters, but none that the choice allows.
    #[error(
        "no GPU adapter matches {ADAPTER_VARIABLE}={choice}\n  this machine has: {available}\n  \
         name one of them, or unset {ADAPTER_VARIABLE}"
    )]
    NoSuchAdapter {
        /// The variable's value.
        choice: String,
        /// Names of the adapters that could be used.
        available: String,
    },
    /// No adapter at all.
    #[error(
        "no usable GPU adapter was found\n  \
         Relief draws with Vulkan, Metal or Direct3D 12 and no driver for any of them answered\n  \
         install a Vulkan driver: `apt-get install mesa-vulkan-drivers` (Debian, Ubuntu), `dnf install mesa-vulkan-drivers` \
         (Fedora), `pacman -S vulkan-swrast` (Arch); on NVIDIA hardware the vendor's driver brings its own"
    )]
    NoAdapter,
    /// An adapter that cannot draw all that scenes may hold.
    #[error(
        "the GPU adapter {adapter} cannot draw what Relief draws\n  it lacks: {lacks}\n  \
         update its driver, or choose another adapter with {ADAPTER_VARIABLE}=NAME ({ADAPTER_VARIABLE}=cpu takes a software driver)"
    )]
    TooWeak {
        /// The adapter's name.
        adapter: String,
        /// What it lacks, separated by commas.
        lacks: String,
    },
    /// The adapter refused to give a device.
    #[error(
        "the GPU adapter {adapter} gave no device\n  {reason}\n  update its driver, or choose another adapter with {ADAPTER_VARIABLE}=NAME"
    )]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
}

/// An adapter with its device and queue.
pub struct Gpu {
    /// Where surfaces are made.
    pub instance: wgpu::Instance,
    /// The adapter; absent for the no-op device.
    pub adapter: Option<wgpu::Adapter>,
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What it offers.
    pub capabilities: Capabilities,
    lost: Arc<Mutex<Option<String>>>,
    error: Arc<Mutex<Option<String>>>,
}

impl Capabilities {
    /// Whether heights that are whole multiples of 1/`units` (those of a map that needs floats: `None`) can be read
    /// through a linear filter, with or without a crater layer.
    pub fn filters_heights(&self, units: Option<u16>, layered: bool) -> bool {
        self.filterable_float32 || (self.unorm16 && units.is_some() && !layered)
    }
}

impl fmt::Debug for Gpu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Gpu").field("adapter", &self.adapter_name()).field("capabilities", &self.capabilities).finish()
    }
}

impl Gpu {
    /// An instance that honours wgpu's environment variables.
    pub fn instance() -> wgpu::Instance {
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env())
    }

    /// The device for drawing without a window.
    ///
    /// # Errors
    /// [`GpuError`] where no adapter answers or it gives no device.
    pub fn headless() -> Result<Arc<Self>, GpuError> {
        Self::headless_with(wgpu::Features::all())
    }

    /// The same with none but these optional features, whatever the adapter offers.
    ///
    /// # Errors
    /// As [`Self::headless`].
    pub fn headless_with(most: wgpu::Features) -> Result<Arc<Self>, GpuError> {
        pollster::block_on(Self::request(Self::instance(), None, most))
    }

    /// The device that can present to `surface`, which `instance` made.
    ///
    /// # Errors
    /// [`GpuError`] where no adapter can present to it or gives no device.
    pub fn for_surface(instance: wgpu::Instance, surface: &wgpu::Surface<'_>) -> Result<Arc<Self>, GpuError> {
        pollster::block_on(Self::request(instance, Some(surface), wgpu::Features::all()))
    }

    /// A device that does nothing: pipelines are validated without a driver.
    pub fn noop() -> Arc<Self> {
        let features = wgpu::Features::FLOAT32_FILTERABLE;
        let (device, queue) =
            wgpu::Device::noop(&wgpu::DeviceDescriptor { required_features: features, ..Default::default() });
        let capabilities = Capabilities {
            timestamps: false,
            filterable_float32: true,
            unorm16: false,
            max_texture: device.limits().max_texture_dimension_2d,
            software: false,
        };
        Arc::new(Self {
            instance: Self::instance(),
            adapter: None,
            device,
            queue,
            capabilities,
            lost: Arc::default(),
            error: Arc::default(),
        })
    }

    /// Names of the adapter and of its driver with the version.
    pub fn adapter_name(&self) -> (String, String) {
        let info = self.device.adapter_info();
        (info.name, format!("{} {}", info.driver, info.driver_info).trim().to_owned())
    }

    /// Why the device was lost, once it is.
    pub fn lost(&self) -> Option<String> {
        self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The first error that nobody caught since the last call: out of memory, for instance.
    pub fn take_error(&self) -> Option<String> {
        self.error.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    async fn request(
        instance: wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
        most: wgpu::Features,
    ) -> Result<Arc<Self>, GpuError> {
        let adapter = Self::choose_adapter(&instance, surface).await?;
        let clock = if std::env::var_os(TIMESTAMPS_VARIABLE).is_some_and(|value| value == "0") {
            wgpu::Features::empty()
        } else {
            wgpu::Features::TIMESTAMP_QUERY
        };
        let wanted = clock | wgpu::Features::FLOAT32_FILTERABLE | wgpu::Features::TEXTURE_FORMAT_16BIT_NORM;
        let granted = adapter.features() & most & wanted;
        let limits = adapter.limits();
        needs::check(&adapter.get_info().name, &limits, adapter.get_downlevel_capabilities().flags)?;
        let capabilities = Capabilities {
            timestamps: granted.contains(wgpu::Features::TIMESTAMP_QUERY),
            filterable_float32: granted.contains(wgpu::Features::FLOAT32_FILTERABLE),
            unorm16: granted.contains(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM),
            max_texture: limits.max_texture_dimension_2d,
            software: adapter.get_info().device_type == wgpu::DeviceType::Cpu,
        };
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("relief"),
                required_features: granted,
                required_limits: limits,
                ..Default::default()
            })
            .await
            .map_err(|error| GpuError::NoDevice { adapter: adapter.get_info().name, reason: error.to_string() })?;
        let lost: Arc<Mutex<Option<String>>> = Arc::default();
        let note = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, message| {
            *note.lock().unwrap_or_else(PoisonError::into_inner) = Some(format!("{reason:?}: {message}"));
        });
        // wgpu's default handler panics. The renderer hands the first error on instead; those that follow from it are
        // of interest to nobody but a debugger.
        let error: Arc<Mutex<Option<String>>> = Arc::default();
        let first = Arc::clone(&error);
        device.on_uncaptured_error(Arc::new(move |error| {
            log::debug!("the GPU reported: {error}");
            first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(|| error.to_string());
        }));
        Ok(Arc::new(Self { instance, adapter: Some(adapter), device, queue, capabilities, lost, error }))
    }

    async fn choose_adapter(
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
    ) -> Result<wgpu::Adapter, GpuError> {
        let choice = std::env::var(ADAPTER_VARIABLE).ok().filter(|name| !name.is_empty());
        if let Some(choice) = choice {
            let wanted = choice.to_lowercase();
            let mut adapters = instance.enumerate_adapters(wgpu::Backends::PRIMARY).await;
            adapters.retain(|adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface)));
            let matches = |adapter: &wgpu::Adapter| {
                let info = adapter.get_info();
                (wanted == "cpu" && info.device_type == wgpu::DeviceType::Cpu)
                    || info.name.to_lowercase().contains(&wanted)
            };
            if let Some(index) = adapters.iter().position(matches) {
                return Ok(adapters.swap_remove(index));
            }
            let names: Vec<_> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
            return Err(if names.is_empty() {
                GpuError::NoAdapter
            } else {
                GpuError::NoSuchAdapter { choice, available: names.join(", ") }
            });
        }
        instance
            .request_adapter(&wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                compatible_surface: surface,
                ..Default::default()
            })
            .await
            .map_err(|_| GpuError::NoAdapter)
    }
}
