// tinybvh's quickest trees for processors, behind functions of C. Rays and hits are halfline's: eight
// numbers a ray, t and face a hit.

#define TINYBVH_IMPLEMENTATION
#include "tiny_bvh.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace {

struct Given {
    float origin[3], t_min, direction[3], t_max;
};

struct Hit {
    float t;
    uint32_t face;
};

struct Trees {
    tinybvh::BVH4_CPU four;
    tinybvh::BVH8_CPU eight;
};

// The constructor would make the direction a unit vector, and t another.
tinybvh::Ray ray_of(const Given& given, float t_max) {
    tinybvh::Ray ray;
    ray.O = {given.origin[0], given.origin[1], given.origin[2]};
    ray.D = {given.direction[0], given.direction[1], given.direction[2]};
    ray.rD = tinybvh::tinybvh_rcp(ray.D);
    ray.hit.t = t_max;
    return ray;
}

template <class Tree> void intersect(const Tree& tree, const Given* rays, Hit* hits, size_t count) {
    for (size_t i = 0; i < count; i++) {
        const float end = std::fmin(rays[i].t_max, BVH_FAR);
        tinybvh::Ray ray = ray_of(rays[i], end);
        tree.Intersect(ray);
        hits[i] = ray.hit.t < end ? Hit{ray.hit.t, ray.hit.prim}
                                  : Hit{std::numeric_limits<float>::infinity(), UINT32_MAX};
    }
}

template <class Tree> void occluded(const Tree& tree, const Given* rays, bool* flags, size_t count) {
    for (size_t i = 0; i < count; i++) {
        flags[i] = tree.IsOccluded(ray_of(rays[i], std::fmin(rays[i].t_max, BVH_FAR)));
    }
}

} // namespace

extern "C" {

void tinybvh_version(uint32_t version[3]) {
    version[0] = TINY_BVH_VERSION_MAJOR;
    version[1] = TINY_BVH_VERSION_MINOR;
    version[2] = TINY_BVH_VERSION_SUB;
}

// Three corners of four numbers for each triangle, which have to stay where they are. The trees are
// never released.
Trees* tinybvh_build(const float* corners, uint32_t triangles) {
    auto* trees = new Trees;
    auto* vertices = reinterpret_cast<const tinybvh::bvhvec4*>(corners);
    trees->four.BuildHQ(vertices, triangles);
    trees->eight.BuildHQ(vertices, triangles);
    return trees;
}

void tinybvh_intersect(const Trees* trees, bool is_wide, const Given* rays, Hit* hits, size_t count) {
    if (is_wide) intersect(trees->eight, rays, hits, count);
    else intersect(trees->four, rays, hits, count);
}

void tinybvh_occluded(const Trees* trees, bool is_wide, const Given* rays, bool* flags, size_t count) {
    if (is_wide) occluded(trees->eight, rays, flags, count);
    else occluded(trees->four, rays, flags, count);
}
}
