#include "scene/denoise_schema.h"

#include "scene/schema_builder.h"

namespace dapple::scene {

const Structure& denoise_schema() {
    using namespace build;
    static const Structure table{
        "denoise",
        {
            choice<&Denoise::filter>(
                "filter", {"none", "fixed", "adaptive"},
                "adaptive: wider where caustics are dark (Kougianos and Moustakas 2021)"),
            integral<&Denoise::passes>("passes", FieldKind::integer,
                                       "each along the rows, then along the columns of the picture")
                .within(1, 100)
                .only_for({"fixed", "adaptive"}),
            integral<&Denoise::radius>("radius", FieldKind::integer, "in pixels, of a pass")
                .within(1, 64)
                .only_for({"fixed"}),
            number<&Denoise::threshold>(
                "threshold", Dimension::number,
                "times the luminance of the weakest light: caustics below a half of it are filtered over 10 "
                "pixels, below a tenth over 15, others over 5; the paper has 0.114 and 0.144")
                .above(0)
                .constant()
                .only_for({"adaptive"}),
            integral<&Denoise::paper_faithful>(
                "paper_faithful", FieldKind::boolean,
                "the paper's weights, each pixel a mean of its neighbors, which changes the sum of light; "
                "otherwise that is kept")
                .only_for({"fixed", "adaptive"}),
        },
        "filter",
        {},
        nullptr};
    return table;
}

}  // namespace dapple::scene
