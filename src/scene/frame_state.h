#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "scene/denoise.h"
#include "scene/medium.h"
#include "scene/transform.h"
#include "scene/water_surface.h"

/// Plain data of one instant. Lengths are metres, times seconds, angles radians; right-handed, y up; the rest
/// plane of the water is y = 0. Colours are linear, in the OCIO role scene_linear.
namespace dapple::scene {

inline constexpr double kDegree = std::numbers::pi / 180;  ///< rad

/// Frames a second as an exact fraction (24000/1001).
struct Rational {
    std::int64_t numerator = 24;
    std::int64_t denominator = 1;
    double value() const { return static_cast<double>(numerator) / static_cast<double>(denominator); }
};

struct Clip {
    std::string name = "clip";
    Rational fps;
    std::int64_t first_frame = 1;
    std::int64_t last_frame = 1;  ///< included
    int width = 960;              ///< pixels
    int height = 540;
    int samples = 4;  ///< camera paths a pixel
    std::uint64_t seed = 0;
};

enum class Projection { perspective, orthographic };

/// The camera is under water when its position is (inside the water's extent and below its surface).
struct Camera {
    Projection projection = Projection::perspective;
    glm::dvec3 position{0, -1, 5};
    glm::dvec3 target{0, -1, 0};
    glm::dvec3 up{0, 1, 0};
    double field_of_view = 50 * kDegree;  ///< rad, vertical, perspective only
    double view_height = 2;               ///< m, height of the picture at any depth, orthographic only
};

enum class ExtentKind {
    pool,        ///< the water ends at the rectangle
    open_water,  ///< for camera rays the rest plane goes on outside the rectangle; light enters inside it
                 ///< only
};

struct Extent {
    ExtentKind kind = ExtentKind::pool;
    glm::dvec2 center{0, 0};  ///< x, z [m]
    glm::dvec2 size{10, 10};  ///< along x, z [m]
};

/// The mesh of open water as nested square rings about the camera, each of cells twice as wide as those of
/// the one inside it (ocean/rings.h).
struct WaterRings {
    double inner_size = 0;  ///< m, side of the innermost square; 0: no rings but a regular grid
    int cells = 256;        ///< across each ring, its hole included; rounded up to a multiple of 4
};

struct Water {
    WaterSurface surface;
    Extent extent;
    /// Triangles of the mesh: cells along x; 0 picks 25 cells a shortest wave, at most 2.1 million triangles.
    int mesh_cells = 0;
    WaterRings rings;  ///< of `waves` and `spectrum`; in place of mesh_cells
    double refractive_index = 1.333;
    /// Index at 450 nm less that at 650 nm (water: 0.0055), for light on its way to receivers: red has
    /// refractive_index - dispersion / 2, blue + dispersion / 2.
    double dispersion = 0;
    JerlovType jerlov = JerlovType::none;     ///< other than none: gives what is not given of the next two
    glm::dvec3 absorption{0.35, 0.06, 0.03};  ///< /m, a channel
    glm::dvec3 scattering{0, 0, 0};           ///< /m, a channel
    PhaseFunction phase;                      ///< of the scattering
    glm::dvec3 extinction() const { return absorption + scattering; }  ///< /m
    /// /m, K_d of the sky term (CONVENTIONS.md); negative: the same as absorption.
    glm::dvec3 diffuse_attenuation{-1, -1, -1};
};

enum class LightType { sun, point, spot, quad, disc };

/// Of an area light, a quad or disc, a frame's lights are its parts, each of which stands for an equal share
/// of the emitter by a point in its middle (scene/area_light.h).
struct EmitterPart {
    int count = 0;  ///< of the emitter's parts; 0: the light is none of these
    /// Of a quad: shares of its width from the left and of its height from below. Of a disc: the square of
    /// the distance from its middle over that of its edge, and a share of a turn.
    glm::dvec2 low{0, 0};
    glm::dvec2 high{1, 1};
    glm::dvec3 center{0, 0, 0};  ///< m, of the whole emitter
    /// m: what the part's points lie off its middle, as covariance u u^T + v v^T.
    glm::dvec3 spread_u{0, 0, 0};
    glm::dvec3 spread_v{0, 0, 0};
};

struct Light {
    std::string name;
    LightType type = LightType::sun;
    /// Unit, of travel; sun, spot, and of area lights the normal of the side that shines; follows from the
    /// three below.
    glm::dvec3 direction{0, -1, 0};
    double elevation = 0;              ///< rad, as written: where the sun stands; see schema.h, sun_direction
    double azimuth = 0;                ///< rad, as written
    glm::dvec3 target{0, 0, 0};        ///< m, as written: where a spot or an area light points
    glm::dvec3 position{0, 3, 0};      ///< m; all but suns; middle of an area light, or of a part of one
    glm::dvec3 irradiance{3, 3, 3};    ///< W/m^2 on a plane that faces the sun
    glm::dvec3 intensity{10, 10, 10};  ///< W/sr; point, and on the axis of a spot or of a part of an emitter
    glm::dvec3 radiance{10, 10, 10};   ///< W/m^2/sr, of an area light in all directions of its side
    glm::dvec2 size{1, 1};             ///< m, of a quad: across and up
    double radius = 0.5;               ///< m, of a disc
    int samples = 16;                  ///< parts that an area light is cut into
    EmitterPart part;
    double angular_diameter = 0.53 * kDegree;  ///< rad, sun; 0 is directional
    double cone_angle = 30 * kDegree;    ///< rad, spot: half-angle where its light has fallen to nothing
    double falloff_angle = 5 * kDegree;  ///< rad, spot: width of the smooth edge inside the cone
    std::string texture;                 ///< path (EXR or PNG), spot: the picture that it throws; empty: none
    /// Rad, spot: by which the picture is turned, clockwise as the light sees it; quad: itself.
    double roll = 0;
};

enum class Shape { plane, box, sphere, mesh };

struct Material {
    glm::dvec3 color{0.5, 0.5, 0.5};  ///< diffuse albedo in [0, 1]
    std::string texture;              ///< path (EXR or PNG), empty: none; multiplies `color`
    double texture_size = 1;          ///< m that one repeat of the texture covers (planes, boxes, spheres)
    bool mirror = false;              ///< perfect specular reflector of `color`
    /// A smooth dielectric: the object is a closed body of it, and has neither colour nor texture. What lies
    /// about it (air or water) ends at its surface; bodies of glass do not overlap.
    bool glass = false;
    double refractive_index = 1.5;         ///< of glass, against air
    glm::dvec3 absorption{0.0, 0.0, 0.0};  ///< /m, a channel, inside glass
};

/// Shapes at the origin: a plane faces +y and measures size.x by size.z; a box measures `size`, centred; a
/// sphere has `radius`; a mesh is read from `file`.
struct Object {
    std::string name;
    Shape shape = Shape::plane;
    glm::dvec3 size{1, 1, 1};  ///< m
    double radius = 0.5;       ///< m
    std::string file;          ///< PLY or OBJ
    Transform transform;
    Material material;
};

/// Constant radiance from all directions of the air that hit nothing [W/m^2/sr]; also lights diffusely
/// (E_sky).
struct Sky {
    glm::dvec3 radiance{0, 0, 0};
};

/// What the boxes of cascades lie about.
enum class CascadeCenter { camera, target, extent };

/// One cascade's own map.
struct CascadeMap {
    int resolution = 1024;  ///< photons along each side of the cascade's box
};

/// Of the methods that start from a caustic map (light/caustic_map.h), all of them. Cascades are square boxes
/// on the rest plane, each `cascade_scale` times as wide as the one inside it, whose photons lie that much
/// wider (Kougianos and Moustakas 2021, section 3.1).
struct CausticMapParameters {
    /// Photons along each side of a cascade's box; of a single map over all the water: along its longer side.
    int map_resolution = 1024;
    double map_precision = 0;  ///< m that photons of the innermost map lie apart; 0: by map_resolution
    int cascades = 1;          ///< N
    double cascade_scale = 2;  ///< s
    double inner_size = 0;     ///< m, side of the innermost box; 0: the outermost is as wide as the water
    CascadeCenter cascade_center = CascadeCenter::camera;
    std::vector<CascadeMap> cascade_maps;  ///< the innermost first; empty: all by map_resolution
    /// The paper's choices: hard borders, boxes in the light's frame that follow the camera without steps.
    bool paper_faithful = false;
    bool second_bounce = false;  ///< light that lands on mirrors is sent on to where it lands next
};

/// What a photon lights where it lands.
enum class PhotonFootprint {
    tent,                 ///< a kernel on the lattice of its neighbours, which reproduces linear functions
    fixed,                ///< its cell of the map, whatever the water does to the beam
    photon_differential,  ///< the cell spread by the derivatives of its ray
    photon_difference,    ///< the cell that its neighbours' rays span where they land
    point,                ///< a pixel; with paper_faithful scaled by the compression ratio (Gruen 2019)
};

struct PhotonSplattingParameters {
    PhotonFootprint footprint = PhotonFootprint::tent;
    double footprint_scale = 1;  ///< of the footprint's sides
};

struct SlicedBeamsParameters {
    int sun_samples = 1;  ///< equal parts of a sun's disc, each traced by its middle and widened by its size
    /// Directions of a sun's disc that each camera segment in a medium is lit from; those of a pixel's camera
    /// samples differ, so that together they cover the disc.
    int volume_sun_samples = 1;
    bool path_counts = true;  ///< whether light paths are counted: layers paths.count, paths.sign, fold
};

struct AdaptiveBeamsParameters {
    int grid = 16;   ///< cells along each side of a light's view before any is split
    int levels = 3;  ///< times that a cell may be split
    /// Pixels that light may land off its place in beams narrower than two pixels, half-widths of a beam in
    /// others: cells are split until then. What the camera does not see is not split.
    double tolerance = 0.05;
    int sun_samples = 1;  ///< equal parts of a sun's disc, each traced by its middle
    /// One area function a beam, scan plane and mid-point, point-in-beam surface term, as in Liktor and
    /// Dachsbacher 2011; else exact intervals and an area function a vertex.
    bool paper_faithful = false;
    double paper_low_pass = 0;  ///< with paper_faithful: pixels that E is blurred by, a standard deviation
};

struct ReferenceParameters {
    /// Rays are added until the mean over pixels of E's standard error, over the mean of E, is below this.
    double standard_error = 0.01;
    int most_rays = 1000;  ///< million a light; the reference ends there though the error is larger
};

/// Pixels for which light scattered by media is computed; at half the rest is interpolated.
enum class VolumeResolution { full, half };

struct Caustics {
    std::string method = "sliced_beams";
    VolumeResolution volume_resolution = VolumeResolution::full;
    BufferScale buffer_scale = BufferScale::full;
    Denoise denoise;
    /// Relative L1 of E over the pixels of a picture that settings of the maps are chosen for; 0: they stand
    /// as they are.
    double target_error = 0;
    SlicedBeamsParameters sliced_beams;
    AdaptiveBeamsParameters adaptive_beams;
    ReferenceParameters reference;
    CausticMapParameters map;
    PhotonSplattingParameters photon_splatting;
};

/// ASC CDL, applied in the role color_timing.
struct ColorDecisionList {
    glm::dvec3 slope{1, 1, 1};
    glm::dvec3 offset{0, 0, 0};
    glm::dvec3 power{1, 1, 1};
    double saturation = 1;
};

struct Output {
    std::string ocio_config;  ///< path; empty: $OCIO, else the shipped config
    std::string display;      ///< empty: the config's default
    std::string view;         ///< empty: the default of the display
    std::string look;         ///< empty: none
    double exposure = 0;      ///< stops
    ColorDecisionList cdl;
};

/// Everything that the timeline says of one frame. A pure function of the timeline and the frame number.
struct FrameState {
    std::int64_t frame = 1;
    double time = 0;  ///< s: (frame - first) / fps
    Clip clip;
    Camera camera;
    std::optional<Water> water;
    std::vector<Light> lights;
    std::vector<Object> objects;
    std::vector<Medium> media;  ///< beside the water itself
    Sky sky;
    Caustics caustics;
    Output output;
};

inline bool has_glass(const FrameState& state) {
    for (const Object& object : state.objects) {
        if (object.material.glass) return true;
    }
    return false;
}

}  // namespace dapple::scene
