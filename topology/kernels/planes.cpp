// Planes through patches of points.
#include "plane.hpp"

// Of each of some patches (count, size, 3), size > 0, what `plane_of` finds: (count, 3) each.
extern "C" void planes_of_patches(const double *patches, int64_t count, int64_t size, double *middles,
                                  double *normals, double *squares) {
    for (int64_t n = 0; n < count; ++n)
        topple::plane_of(patches + 3 * size * n, size, middles + 3 * n, normals + 3 * n, squares + 3 * n);
}
