// Boxes that meet. No include guard: see lanes.h.

/// Which of the boxes, grown by their radii, meet a box grown by its radius.
unsigned meeting_boxes(const BoxBlock& boxes, const double* minimum, const double* maximum, double radius)
{
    const Doubles reach = load<Doubles>(boxes.radius) + radius, zero = {};
    Doubles squared = zero;
    for (int axis = 0; axis < 3; ++axis)
    {
        const Doubles before = minimum[axis] - load<Doubles>(boxes.maximum[axis]),
                      behind = load<Doubles>(boxes.minimum[axis]) - maximum[axis];
        Doubles apart = before > behind ? before : behind;
        apart = apart > zero ? apart : zero;
        squared += apart * apart;
    }
    return at_most(squared, reach * reach);
}
