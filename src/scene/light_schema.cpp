#include "scene/light_schema.h"

#include "scene/schema_builder.h"

namespace dapple::scene {
namespace {

using namespace build;

/// A vector of length 0 stays: checks find it where the timeline is read.
glm::dvec3 direction_of(const glm::dvec3& v) {
    const double length = glm::length(v);
    return length > 0 ? v / length : v;
}

void derive_light(void* object, const std::vector<std::string_view>& given) {
    auto& light = *static_cast<Light*>(object);
    if (has(given, "elevation"))
        light.direction = sun_direction(light.elevation, light.azimuth);
    else if (has(given, "target"))
        light.direction = direction_of(light.target - light.position);
    else
        light.direction = direction_of(light.direction);
}

}  // namespace

const Structure& light_schema() {
    const double right_angle = radians_from_degrees(90);
    static const Structure table{
        "light",
        {
            member<&Light::name>("name", FieldKind::text, "for --set and messages"),
            choice<&Light::type>("type", {"sun", "point", "spot", "quad", "disc"}, "what kind of light")
                .required(),
            number<&Light::elevation>("elevation", Dimension::angle,
                                      "height above the horizon; 90 deg is overhead")
                .range({0, right_angle, true, false})
                .no_default()
                .only_for({"sun"}),
            number<&Light::azimuth>("azimuth", Dimension::angle,
                                    "where the sun stands: 0 is +x, 90 deg is +z")
                .only_for({"sun"}),
            number<&Light::direction>("direction", Dimension::number, "in which the light travels")
                .no_default()
                .only_for({"sun", "spot", "quad", "disc"}),
            number<&Light::target>("target", Dimension::length, "point that the light faces, for direction")
                .no_default()
                .only_for({"spot", "quad", "disc"}),
            number<&Light::irradiance>("irradiance", Dimension::irradiance, "on a plane that faces the sun")
                .at_least(0)
                .one_for_all()
                .only_for({"sun"}),
            number<&Light::angular_diameter>("angular_diameter", Dimension::angle,
                                             "of the sun's disc; 0: directional")
                .range({0, right_angle, false, true})
                .only_for({"sun"}),
            number<&Light::position>("position", Dimension::length,
                                     "where the light stands; middle of a quad or disc")
                .only_for({"point", "spot", "quad", "disc"}),
            number<&Light::intensity>("intensity", Dimension::intensity, "of a spot: on its axis")
                .at_least(0)
                .one_for_all()
                .only_for({"point", "spot"}),
            number<&Light::cone_angle>("cone_angle", Dimension::angle,
                                       "from the axis to where the light ends")
                .range({0, right_angle, true, false})
                .only_for({"spot"}),
            number<&Light::falloff_angle>("falloff_angle", Dimension::angle,
                                          "width of the soft edge inside the cone")
                .range({0, right_angle, false, false})
                .only_for({"spot"}),
            member<&Light::texture>("texture", FieldKind::path,
                                    "EXR or PNG that the spot throws like a slide, and that multiplies the "
                                    "intensity; its largest circle fills the cone, upright")
                .only_for({"spot"}),
            number<&Light::roll>("roll", Dimension::angle,
                                 "by which the picture of the texture is turned clockwise, as the light sees "
                                 "it; of a spot that shines straight down -z is up in the picture")
                .only_for({"spot"}),
            number<&Light::roll>("roll", Dimension::angle,
                                 "by which the quad is turned clockwise, as it sees its light; -z is up of "
                                 "one that faces straight down")
                .only_for({"quad"}),
            number<&Light::radiance>("radiance", Dimension::radiance,
                                     "the same in all directions of the side that shines; the other is dark")
                .at_least(0)
                .one_for_all()
                .only_for({"quad", "disc"}),
            number<&Light::size>("size", Dimension::length, "of the quad, across and up")
                .above(0)
                .only_for({"quad"}),
            number<&Light::radius>("radius", Dimension::length, "of the disc").above(0).only_for({"disc"}),
            integral<&Light::samples>(
                "samples", FieldKind::integer,
                "equal parts that an area light is cut into; each lights by its middle, "
                "widened by its size where the method can")
                .within(1, 1024)
                .only_for({"quad", "disc"}),
        },
        "type",
        {{"sun", {{"elevation", "azimuth"}, {"direction"}}},
         {"spot", {{"direction"}, {"target"}}},
         {"quad", {{"direction"}, {"target"}}},
         {"disc", {{"direction"}, {"target"}}}},
        &derive_light};
    return table;
}

}  // namespace dapple::scene
