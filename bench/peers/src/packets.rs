//! How Embree's functions take rays, one by one or in packets: what `embree4/rtcore_ray.h` declares.

use std::ffi::c_void;
use std::fmt;

use halfline::{HitF32, RayF32};

use crate::transpose::{self, FAR, INVALID, Rows, has_registers_for, transpose};

/// A device, scene or geometry of Embree's.
pub type Handle = *mut c_void;

/// How rays are handed over.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Packets {
    /// Rays of a packet: 1, 4, 8 or 16.
    pub width: usize,
    /// Whether Embree is told that they go alike.
    pub is_coherent: bool,
}

/// All ways to hand rays over; of single rays none is told.
pub const ALL_PACKETS: [Packets; 7] = [
    Packets { width: 1, is_coherent: false },
    Packets { width: 4, is_coherent: false },
    Packets { width: 4, is_coherent: true },
    Packets { width: 8, is_coherent: false },
    Packets { width: 8, is_coherent: true },
    Packets { width: 16, is_coherent: false },
    Packets { width: 16, is_coherent: true },
];

impl fmt::Display for Packets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.width, self.is_coherent) {
            (1, _) => write!(f, "Single"),
            (width, false) => write!(f, "Incoherent{width}"),
            (width, true) => write!(f, "Coherent{width}"),
        }
    }
}

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which are the same, and room for what later
/// versions append.
#[repr(C)]
pub struct Arguments {
    flags: u32,
    feature_mask: u32,
    context: *mut c_void,
    filter: *mut c_void,
    intersect: *mut c_void,
    later: [usize; 4],
}

impl Arguments {
    fn new(is_coherent: bool) -> Arguments {
        let null = std::ptr::null_mut();
        Arguments {
            flags: u32::from(is_coherent) << 16,
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
pub struct RayHit {
    origin_and_near: [f32; 4],
    direction_and_time: [f32; 4],
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

/// `RTCRayHit4`, 8 or 16, all of them aligned as the largest demands.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub struct RayHits<const N: usize> {
    rays: Rows<N>,
    mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
    normal: [[f32; N]; 3],
    u: [f32; N],
    v: [f32; N],
    primitive: [u32; N],
    geometry: [u32; N],
    instance: [u32; N],
    later: [[u32; N]; 4],
}

/// Which lanes of a packet count.
#[repr(align(64))]
struct Valid<const N: usize>([i32; N]);

/// `rtcIntersect1` or `rtcOccluded1`; to the latter a ray suffices, with which a ray and hit begins.
pub type CastSingle = unsafe extern "C" fn(Handle, *mut RayHit, *mut Arguments);

/// `rtcIntersect4` and so on.
pub type CastPacket<const N: usize> =
    unsafe extern "C" fn(*const i32, Handle, *mut RayHits<N>, *mut Arguments);

/// Embree's functions for closest or for any hits.
pub struct Casts {
    pub single: CastSingle,
    pub four: CastPacket<4>,
    pub eight: CastPacket<8>,
    pub sixteen: CastPacket<16>,
}

/// What is asked of a ray, and how the answer is read.
pub trait Answer: Copy {
    /// The answer of a ray that hits nothing.
    const MISS: Self;

    /// Whether hits are read, and have to be reset therefore.
    const READS_HITS: bool;

    fn of_single(query: &RayHit) -> Self;
    fn of_packet<const N: usize>(query: &RayHits<N>, answers: &mut [Self; N]);
}

/// The closest hit.
impl Answer for HitF32 {
    const MISS: HitF32 = HitF32::MISS;
    const READS_HITS: bool = true;

    #[inline(always)]
    fn of_single(query: &RayHit) -> HitF32 {
        let is_hit = query.primitive != INVALID;
        HitF32 { t: if is_hit { query.far } else { f32::INFINITY }, face: query.primitive }
    }

    #[inline(always)]
    fn of_packet<const N: usize>(query: &RayHits<N>, answers: &mut [HitF32; N]) {
        transpose::hits(&query.rays[FAR], &query.primitive, answers);
    }
}

/// Whether there is any hit.
impl Answer for bool {
    const MISS: bool = false;
    const READS_HITS: bool = false;

    #[inline(always)]
    fn of_single(query: &RayHit) -> bool {
        query.far < 0.0
    }

    #[inline(always)]
    fn of_packet<const N: usize>(query: &RayHits<N>, answers: &mut [bool; N]) {
        for (answer, far) in answers.iter_mut().zip(query.rays[FAR]) {
            *answer = far < 0.0;
        }
    }
}

/// Casts rays into a scene.
///
/// # Safety
/// The functions are Embree's for such answers, and the scene is committed.
pub unsafe fn cast<A: Answer>(
    casts: &Casts,
    packets: Packets,
    scene: Handle,
    rays: &[RayF32],
    answers: &mut [A],
) {
    let is_coherent = packets.is_coherent;
    // SAFETY: the caller's promise.
    unsafe {
        match packets.width {
            4 => cast_packets(casts.four, is_coherent, scene, rays, answers),
            8 => cast_packets(casts.eight, is_coherent, scene, rays, answers),
            16 => cast_packets(casts.sixteen, is_coherent, scene, rays, answers),
            _ => cast_singles(casts.single, scene, rays, answers),
        }
    }
}

/// One by one.
///
/// # Safety
/// As for [`cast`].
unsafe fn cast_singles<A: Answer>(
    function: CastSingle,
    scene: Handle,
    rays: &[RayF32],
    answers: &mut [A],
) {
    let mut arguments = Arguments::new(false);
    // SAFETY: plain numbers, for which zeros are valid.
    let mut query: RayHit = unsafe { std::mem::zeroed() };
    query.mask = u32::MAX;
    for (ray, answer) in rays.iter().zip(answers) {
        let [x, y, z] = ray.origin;
        query.origin_and_near = [x, y, z, ray.t_min];
        transpose::direction(ray, &mut query.direction_and_time);
        query.far = ray.t_max;
        if A::READS_HITS {
            query.primitive = INVALID;
            query.geometry = INVALID;
        }
        // SAFETY: the caller's promise; the query is aligned as Embree demands.
        unsafe { function(scene, &mut query, &mut arguments) };
        *answer = A::of_single(&query);
    }
}

/// Packet by packet; the last may have fewer rays.
///
/// # Safety
/// As for [`cast`].
unsafe fn cast_packets<A: Answer, const N: usize>(
    function: CastPacket<N>,
    is_coherent: bool,
    scene: Handle,
    rays: &[RayF32],
    answers: &mut [A],
) {
    let mut arguments = Arguments::new(is_coherent);
    let has_registers = has_registers_for(N);
    // SAFETY: plain numbers, for which zeros are valid.
    let mut query: RayHits<N> = unsafe { std::mem::zeroed() };
    query.mask = [u32::MAX; N];
    let mut cast = |valid: &Valid<N>, rays: &[RayF32; N], answers: &mut [A; N]| {
        transpose(rays, &mut query.rays, has_registers);
        if A::READS_HITS {
            query.primitive = [INVALID; N];
            query.geometry = [INVALID; N];
        }
        // SAFETY: the caller's promise; valid and query are aligned as Embree demands.
        unsafe { function(valid.0.as_ptr(), scene, &mut query, &mut arguments) };
        A::of_packet(&query, answers);
    };

    let (packets, rest) = rays.as_chunks();
    let (places, last_places) = answers.as_chunks_mut();
    for (rays, answers) in packets.iter().zip(places) {
        cast(&Valid([-1; N]), rays, answers);
    }
    if let Some(&first) = rest.first() {
        // Fill the last packet up with rays that do not count.
        let (mut valid, mut last) = (Valid([0; N]), [first; N]);
        valid.0[..rest.len()].fill(-1);
        last[..rest.len()].copy_from_slice(rest);
        let mut found = [A::MISS; N];
        cast(&valid, &last, &mut found);
        last_places.copy_from_slice(&found[..rest.len()]);
    }
}
