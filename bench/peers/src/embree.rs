//! Embree 4 through its C interface, from a shared library that is opened at run time: the one in
//! PyPI's wheel of embreex.
//!
//! Declared here is what `embree4/rtcore*.h` declares, as far as it is used.

use std::ffi::{c_char, c_void};
use std::path::Path;
use std::sync::atomic::{AtomicIsize, Ordering::Relaxed};

use halfline::mesh::Positions;
use halfline::{HitF32, Mesh, RayF32};
use libloading::{Library, Symbol};

use crate::transpose::{FAR, Rows, has_wide_registers, one_by_one, transpose};

type Handle = *mut c_void;

const GEOMETRY_TRIANGLE: u32 = 0;
const BUFFER_INDEX: u32 = 0;
const BUFFER_VERTEX: u32 = 1;
const FORMAT_UINT3: u32 = 0x5003;
const FORMAT_FLOAT3: u32 = 0x9003;
const SCENE_ROBUST: u32 = 4;
const INVALID: u32 = u32::MAX;

/// How good a tree Embree builds.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Quality {
    Medium = 1,
    High = 2,
}

/// How rays are handed over.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Packets {
    Single,
    Incoherent16,
    Coherent16,
}

pub const ALL_PACKETS: [Packets; 3] = [Packets::Single, Packets::Incoherent16, Packets::Coherent16];

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which are the same, and room for what later
/// versions append.
#[repr(C)]
struct Arguments {
    flags: u32,
    feature_mask: u32,
    context: *mut c_void,
    filter: *mut c_void,
    intersect: *mut c_void,
    later: [usize; 4],
}

impl Arguments {
    fn new(packets: Packets) -> Arguments {
        let flags = if packets == Packets::Coherent16 { 1 << 16 } else { 0 };
        let null = std::ptr::null_mut();
        Arguments {
            flags,
            feature_mask: u32::MAX,
            context: null,
            filter: null,
            intersect: null,
            later: [0; 4],
        }
    }
}

/// `RTCRayHit`, and room for optional fields at its end.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct RayHit {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: u32,
    geometry: u32,
    instance: u32,
    later: [u32; 8],
}

/// `RTCRayHit16`.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct RayHit16 {
    rays: Rows,
    mask: [u32; 16],
    id: [u32; 16],
    flags: [u32; 16],
    normal: [[f32; 16]; 3],
    u: [f32; 16],
    v: [f32; 16],
    primitive: [u32; 16],
    geometry: [u32; 16],
    instance: [u32; 16],
    later: [[u32; 16]; 4],
}

type Cast1 = unsafe extern "C" fn(Handle, *mut RayHit, *mut Arguments);
type Cast16 = unsafe extern "C" fn(*const i32, Handle, *mut RayHit16, *mut Arguments);

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
    intersect1: Cast1,
    occluded1: Cast1,
    intersect16: Cast16,
    occluded16: Cast16,
}

impl Embree {
    pub fn open(path: &Path) -> Result<Embree, libloading::Error> {
        // SAFETY: the library is Embree, which has no initialisers that could do harm, and its
        // functions have the types of its headers.
        unsafe {
            let library = Library::new(path)?;
            let symbol1 = |name: &str| -> Result<Cast1, _> { Ok(*library.get(name.as_bytes())?) };
            let symbol16 = |name: &str| -> Result<Cast16, _> { Ok(*library.get(name.as_bytes())?) };
            let (intersect1, occluded1) = (symbol1("rtcIntersect1")?, symbol1("rtcOccluded1")?);
            let (intersect16, occluded16) =
                (symbol16("rtcIntersect16")?, symbol16("rtcOccluded16")?);
            Ok(Embree { library, intersect1, occluded1, intersect16, occluded16 })
        }
    }

    fn function<T>(&self, name: &str) -> Symbol<'_, T> {
        // SAFETY: callers give the types of Embree's headers.
        unsafe { self.library.get(name.as_bytes()) }.expect("a function of Embree 4")
    }

    /// The version, as 40400 for 4.4.0.
    pub fn version(&self) -> i64 {
        let device = self.device(1);
        // SAFETY: types as in the headers; property 0 is the version.
        unsafe {
            let property: Symbol<unsafe extern "C" fn(Handle, u32) -> isize> =
                self.function("rtcGetDeviceProperty");
            property(device, 0) as i64
        }
    }

    fn device(&self, threads: usize) -> Handle {
        let configuration = format!("threads={threads},set_affinity=0,hugepages=1\0");
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
        if packets == Packets::Single {
            let mut arguments = Arguments::new(packets);
            for (ray, hit) in rays.iter().zip(hits) {
                let mut query = single(ray);
                // SAFETY: types as in the headers.
                unsafe { (self.embree.intersect1)(self.scene, &mut query, &mut arguments) };
                let is_hit = query.geometry != INVALID;
                hit.t = if is_hit { query.far } else { f32::INFINITY };
                hit.face = query.primitive;
            }
            return;
        }
        self.in_packets(packets, rays, self.embree.intersect16, |query, first, count| {
            for (lane, hit) in hits[first..first + count].iter_mut().enumerate() {
                let is_hit = query.geometry[lane] != INVALID;
                hit.t = if is_hit { query.rays[FAR][lane] } else { f32::INFINITY };
                hit.face = query.primitive[lane];
            }
        });
    }

    /// Whether each ray hits anything.
    pub fn occluded(&self, packets: Packets, rays: &[RayF32], hits: &mut [bool]) {
        if packets == Packets::Single {
            let mut arguments = Arguments::new(packets);
            for (ray, hit) in rays.iter().zip(hits) {
                let mut query = single(ray);
                // SAFETY: types as in the headers; a ray is where a ray and hit begins.
                unsafe { (self.embree.occluded1)(self.scene, &mut query, &mut arguments) };
                *hit = query.far < 0.0;
            }
            return;
        }
        self.in_packets(packets, rays, self.embree.occluded16, |query, first, count| {
            for (lane, hit) in hits[first..first + count].iter_mut().enumerate() {
                *hit = query.rays[FAR][lane] < 0.0;
            }
        });
    }

    fn in_packets(
        &self,
        packets: Packets,
        rays: &[RayF32],
        cast: Cast16,
        mut take: impl FnMut(&RayHit16, usize, usize),
    ) {
        let mut arguments = Arguments::new(packets);
        let is_wide = has_wide_registers();
        // SAFETY: plain numbers, for which zeros are valid.
        let mut query: RayHit16 = unsafe { std::mem::zeroed() };
        query.mask = [u32::MAX; 16];
        let mut valid = Aligned([-1; 16]);
        for (number, rays) in rays.chunks(16).enumerate() {
            if let Ok(rays) = rays.try_into() {
                transpose(rays, &mut query.rays, is_wide);
            } else {
                one_by_one(rays, &mut query.rays);
                valid.0[rays.len()..].fill(0);
            }
            query.geometry = [INVALID; 16];
            query.primitive = [INVALID; 16];
            query.instance = [INVALID; 16];
            // SAFETY: types as in the headers, aligned as they demand.
            unsafe { cast(valid.0.as_ptr(), self.scene, &mut query, &mut arguments) };
            take(&query, number * 16, rays.len());
        }
    }
}

#[repr(align(64))]
struct Aligned([i32; 16]);

#[inline(always)]
fn single(ray: &RayF32) -> RayHit {
    RayHit {
        origin: ray.origin,
        near: ray.t_min,
        direction: ray.direction,
        time: 0.0,
        far: ray.t_max,
        mask: u32::MAX,
        id: 0,
        flags: 0,
        normal: [0.0; 3],
        u: 0.0,
        v: 0.0,
        primitive: INVALID,
        geometry: INVALID,
        instance: INVALID,
        later: [INVALID; 8],
    }
}
