#pragma once

#include "filter_amls/cells/cells.h"
#include "filter_amls/fits/fit.h"
#include "filter_amls/sides/crust_of_points.h"
#include "residual_field.h"
#include "surface.h"

#include <recon/search/block_search.h>
#include <recon/search/spatial_order.h>

#include <memory>

namespace recon
{

/// Everything in the unit frame.
struct AmlsSurface::Data
{
    explicit Data(UnitFrame f) : frame(f) {}
    Data(const Data&) = delete;

    UnitFrame frame;
    SpatialOrder spatial; ///< Of the input points.
    Points points;        ///< The distinct ones, in that order.
    BlockSearch point_search;
    Cells cells;
    BlockSearch cell_search;  ///< Of the cells' means.
    CellNormals cell_normals; ///< Normals outward.
    /// Per cell: those of the fits before sides were known, which heed walls behind and small things beside large
    /// ones, or that rho_e asks for. Samples of the surface lie as densely as these tell.
    std::vector<double> sampling_widths;
    Vectors cell_sides; ///< The same after follow_anchors(): in which half space points look for the surface.
    std::vector<Anchor> anchors;
    Points anchor_positions;
    BlockSearch anchor_search;
    std::vector<double> anchor_spacing; ///< Distance of neighbouring anchors, per anchor.
    Points poles;                       ///< Of the landmarks.
    BlockSearch pole_search;
    std::vector<ResidualField> residuals; ///< One after the other; none if they tell nothing.
    bool sharp = true;                    ///< How `projected` was projected, see AmlsProjectionOptions.
    AmlsProjection projected;             ///< The points, else by default options; empty if residuals were not asked.
    std::shared_ptr<CrustOfPoints> crust; ///< Of `points`.
    AmlsSurfaceReport report;

    /// Whether these are the points of which the surface was made, in the same order.
    bool was_made_of(const Points& queries) const
    {
        if (queries.size() != spatial.representative.size())
            return false;
        for (std::size_t i = 0; i < queries.size(); ++i)
        {
            const int s = spatial.representative[i];
            const Point q = frame.to_unit(queries[i]);
            const bool merged = spatial.order[s] != int(i); // with another so near that both count as one
            if (merged ? (q - points[s]).norm() > 2 * spot_size : q != points[s])
                return false;
        }
        return true;
    }
};

} // namespace recon
