#pragma once

#include "cells.h"
#include "fit.h"
#include "surface.h"

#include <recon/neighbours.h>

namespace recon
{

/// Everything in the unit frame.
struct AmlsSurface::Data
{
    Data(UnitFrame f, Cells c, Vectors normals, Points feet_, std::vector<CellKind> k, std::vector<Anchor> a)
        : frame(f), cells(std::move(c)), cell_normals(std::move(normals)), feet(std::move(feet_)), kinds(std::move(k)),
          anchors(std::move(a)), positions(positions_of(anchors)), cell_search(cells.means), anchor_search(positions)
    {
    }

    UnitFrame frame;
    Cells cells;
    Vectors cell_normals; ///< Outward.
    Points feet;
    std::vector<CellKind> kinds;
    std::vector<Anchor> anchors;
    Points positions; ///< Of the anchors.
    NeighbourSearch cell_search, anchor_search;
    std::vector<double> anchor_spacing; ///< Distance of neighbouring anchors, per anchor [unit].
    std::vector<double> feature_size;   ///< Per anchor [unit]; infinite where there is no pole.
    AmlsSurfaceReport report;

private:
    static Points positions_of(const std::vector<Anchor>& anchors)
    {
        Points positions;
        for (const Anchor& a : anchors)
            positions.push_back(a.position);
        return positions;
    }
};

} // namespace recon
