//! Embree 4 through its C interface, from a shared library that is opened at run time: the one in
//! PyPI's wheel of embreex.
//!
//! Declared here is what `embree4/rtcore*.h` declares, as far as it is used.

use std::ffi::{c_char, c_void};
use std::path::Path;
use std::sync::atomic::{AtomicIsize, Ordering::Relaxed};

use halfline::mesh::Positions;
use halfline::{HitF32, Level, Mesh, RayF32};
use libloading::{Library, Symbol};

use crate::packets::{CastPacket, CastSingle, Casts, Handle, Packets, cast};

const GEOMETRY_TRIANGLE: u32 = 0;
const BUFFER_INDEX: u32 = 0;
const BUFFER_VERTEX: u32 = 1;
const FORMAT_UINT3: u32 = 0x5003;
const FORMAT_FLOAT3: u32 = 0x9003;
const SCENE_ROBUST: u32 = 4;
const PROPERTY_VERSION: u32 = 0;
const PROPERTY_NATIVE_8: u32 = 33;
const PROPERTY_NATIVE_16: u32 = 34;

/// How good a tree Embree builds.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Quality {
    Medium = 1,
    High = 2,
}

/// What a device holds in bytes, and the most that it held.
#[derive(Default)]
struct Memory {
    held: AtomicIsize,
    peak: AtomicIsize,
}

/// `RTCMemoryMonitorFunction`: Embree tells of each allocation, and of each release as a negative
/// number.
///
/// # Safety
/// `memory` is a [`Memory`].
unsafe extern "C" fn monitor(memory: *mut c_void, bytes: isize, _: bool) -> bool {
    // SAFETY: the caller's promise.
    let memory = unsafe { &*memory.cast::<Memory>() };
    memory.peak.fetch_max(memory.held.fetch_add(bytes, Relaxed) + bytes, Relaxed);
    true
}

/// The library.
pub struct Embree {
    library: Library,
    intersect: Casts,
    occluded: Casts,
    /// The one instruction set that it shall use, if halfline's is forced.
    forced: Option<&'static str>,
}

impl Embree {
    /// Opens the library. `forced` is the instruction set that halfline was told to use; Embree
    /// keeps to the same.
    pub fn open(path: &Path, forced: Option<Level>) -> Result<Embree, libloading::Error> {
        let forced = forced.and_then(|level| match level.name() {
            "scalar" if cfg!(target_arch = "x86_64") => Some("sse2"),
            "scalar" => None,
            name => Some(name),
        });
        // SAFETY: the library is Embree, which has no initialisers that could do harm, and its
        // functions have the types of its headers.
        unsafe {
            let library = Library::new(path)?;
            let casts = |what: &str| -> Result<Casts, libloading::Error> {
                let name = |width: usize| format!("rtc{what}{width}");
                let four: Symbol<CastPacket<4>> = library.get(name(4).as_bytes())?;
                let eight: Symbol<CastPacket<8>> = library.get(name(8).as_bytes())?;
                let sixteen: Symbol<CastPacket<16>> = library.get(name(16).as_bytes())?;
                let single: Symbol<CastSingle> = library.get(name(1).as_bytes())?;
                Ok(Casts { single: *single, four: *four, eight: *eight, sixteen: *sixteen })
            };
            let (intersect, occluded) = (casts("Intersect")?, casts("Occluded")?);
            Ok(Embree { library, intersect, occluded, forced })
        }
    }

    fn function<T>(&self, name: &str) -> Symbol<'_, T> {
        // SAFETY: callers give the types of Embree's headers.
        unsafe { self.library.get(name.as_bytes()) }.expect("a function of Embree 4")
    }

    /// The version, as 40400 for 4.4.0.
    pub fn version(&self) -> isize {
        self.property(PROPERTY_VERSION)
    }

    /// The instruction set that it uses, by the widest packets that are native to it.
    pub fn instruction_set(&self) -> &'static str {
        if !cfg!(target_arch = "x86_64") {
            "neon"
        } else if self.property(PROPERTY_NATIVE_16) != 0 {
            "avx512"
        } else if self.property(PROPERTY_NATIVE_8) == 0 {
            "sse"
        } else if Level::available().iter().any(|level| level.name() == "avx2") {
            "avx2"
        } else {
            "avx"
        }
    }

    fn property(&self, number: u32) -> isize {
        let device = self.device(1);
        // SAFETY: types as in the headers.
        unsafe {
            let property: Symbol<unsafe extern "C" fn(Handle, u32) -> isize> =
                self.function("rtcGetDeviceProperty");
            property(device, number)
        }
    }

    fn device(&self, threads: usize) -> Handle {
        let isa = self.forced.map(|name| format!(",isa={name}")).unwrap_or_default();
        let configuration = format!("threads={threads},set_affinity=0,hugepages=1{isa}\0");
        // SAFETY: types as in the headers; the string ends with a zero.
        unsafe {
            let new: Symbol<unsafe extern "C" fn(*const c_char) -> Handle> =
                self.function("rtcNewDevice");
            new(configuration.as_ptr().cast())
        }
    }

    /// Builds a scene over the mesh, on so many threads. Neither scene nor device is ever released.
    pub fn scene(
        &self,
        mesh: &SingleMesh,
        quality: Quality,
        robust: bool,
        threads: usize,
    ) -> Scene<'_> {
        let device = self.device(threads);
        let memory: &'static Memory = Box::leak(Box::default());
        // SAFETY: types as in the headers; the memory's figures are never released.
        unsafe {
            type Monitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;
            let set_monitor: Symbol<unsafe extern "C" fn(Handle, Monitor, *mut c_void)> =
                self.function("rtcSetDeviceMemoryMonitorFunction");
            set_monitor(device, monitor, std::ptr::from_ref(memory).cast_mut().cast());
        }
        // SAFETY: types as in the headers; the buffers outlive the scene, as the mesh is leaked by
        // the caller, and have room for one more element, as Embree demands.
        unsafe {
            let new_scene: Symbol<unsafe extern "C" fn(Handle) -> Handle> =
                self.function("rtcNewScene");
            let set_quality: Symbol<unsafe extern "C" fn(Handle, u32)> =
                self.function("rtcSetSceneBuildQuality");
            let set_flags: Symbol<unsafe extern "C" fn(Handle, u32)> =
                self.function("rtcSetSceneFlags");
            let new_geometry: Symbol<unsafe extern "C" fn(Handle, u32) -> Handle> =
                self.function("rtcNewGeometry");
            type SetBuffer =
                unsafe extern "C" fn(Handle, u32, u32, u32, *const c_void, usize, usize, usize);
            let set_buffer: Symbol<SetBuffer> = self.function("rtcSetSharedGeometryBuffer");
            let geometry_quality: Symbol<unsafe extern "C" fn(Handle, u32)> =
                self.function("rtcSetGeometryBuildQuality");
            let commit_geometry: Symbol<unsafe extern "C" fn(Handle)> =
                self.function("rtcCommitGeometry");
            let attach: Symbol<unsafe extern "C" fn(Handle, Handle) -> u32> =
                self.function("rtcAttachGeometry");
            let commit: Symbol<unsafe extern "C" fn(Handle)> = self.function("rtcCommitScene");

            let scene = new_scene(device);
            set_quality(scene, quality as u32);
            set_flags(scene, if robust { SCENE_ROBUST } else { 0 });
            let geometry = new_geometry(device, GEOMETRY_TRIANGLE);
            geometry_quality(geometry, quality as u32);
            let SingleMesh { positions, triangles } = mesh;
            set_buffer(
                geometry,
                BUFFER_VERTEX,
                0,
                FORMAT_FLOAT3,
                positions.as_ptr().cast(),
                0,
                12,
                positions.len() - 1,
            );
            set_buffer(
                geometry,
                BUFFER_INDEX,
                0,
                FORMAT_UINT3,
                triangles.as_ptr().cast(),
                0,
                12,
                triangles.len(),
            );
            commit_geometry(geometry);
            attach(scene, geometry);
            commit(scene);
            Scene { embree: self, scene, memory }
        }
    }
}

/// A mesh in single precision; the last position is room only.
pub struct SingleMesh {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

impl SingleMesh {
    pub fn of(mesh: &Mesh) -> SingleMesh {
        let mut positions: Vec<_> = match mesh.positions() {
            Positions::F32(positions) => positions.to_vec(),
            Positions::F64(positions) => positions.iter().map(|p| p.map(|x| x as f32)).collect(),
        };
        positions.push([0.0; 3]);
        SingleMesh { positions, triangles: mesh.triangles().to_vec() }
    }
}

/// A built scene.
pub struct Scene<'a> {
    embree: &'a Embree,
    scene: Handle,
    memory: &'static Memory,
}

// SAFETY: a committed scene may be asked from several threads, as Embree documents.
unsafe impl Sync for Scene<'_> {}

impl Scene<'_> {
    /// Bytes of the tree.
    pub fn bytes(&self) -> usize {
        self.memory.held.load(Relaxed).unsigned_abs()
    }

    /// The most bytes that building held at a time.
    pub fn peak_bytes(&self) -> usize {
        self.memory.peak.load(Relaxed).unsigned_abs()
    }

    /// The closest hit of each ray.
    pub fn intersect(&self, packets: Packets, rays: &[RayF32], hits: &mut [HitF32]) {
        // SAFETY: the functions are for closest hits, and the scene is committed.
        unsafe { cast(&self.embree.intersect, packets, self.scene, rays, hits) };
    }

    /// Whether each ray hits anything.
    pub fn occluded(&self, packets: Packets, rays: &[RayF32], flags: &mut [bool]) {
        // SAFETY: the functions are for any hits, and the scene is committed.
        unsafe { cast(&self.embree.occluded, packets, self.scene, rays, flags) };
    }
}
