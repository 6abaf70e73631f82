#pragma once

#include "cells.h"
#include "fit.h"
#include "surface.h"

#include <recon/neighbours.h>
#include <recon/spatial_order.h>

namespace recon
{

/// Everything in the unit frame.
struct AmlsSurface::Data
{
    explicit Data(UnitFrame f) : frame(f) {}
    Data(const Data&) = delete; // the searches keep references

    UnitFrame frame;
    SpatialOrder spatial; ///< Of the input points.
    Points points;        ///< The distinct ones, in that order.
    Cells cells;
    NeighbourSearch cell_search{cells.means};
    CellNormals cell_normals; ///< Normals outward.
    std::vector<Anchor> anchors;
    Points anchor_positions;
    NeighbourSearch anchor_search{anchor_positions};
    std::vector<double> anchor_spacing; ///< Distance of neighbouring anchors, per anchor.
    AmlsSurfaceReport report;

    /// Whether these are the points of which the surface was made, in the same order.
    bool was_made_of(const Points& queries) const
    {
        if (queries.size() != spatial.representative.size())
            return false;
        for (std::size_t i = 0; i < queries.size(); ++i)
            if (frame.to_unit(queries[i]) != points[spatial.representative[i]])
                return false;
        return true;
    }
};

} // namespace recon
