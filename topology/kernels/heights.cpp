// Plan views: the highest or lowest point over each cell of a grid.
#include <cmath>
#include <cstdint>

// The greatest of sign * height of points (count, 3) over each cell of a plan (size[0], size[1]), which the
// caller filled with what is less. Cells count from `corner`, the first of the plan has the number `first`.
extern "C" void heights_over(const double *points, int64_t count, const double *corner, double cell,
                             const int64_t *first, const int64_t *size, double sign, double *plan) {
    for (int64_t i = 0; i < count; ++i) {
        const double *p = points + 3 * i;
        const double x = std::floor((p[0] - corner[0]) / cell) - static_cast<double>(first[0]);
        const double y = std::floor((p[1] - corner[1]) / cell) - static_cast<double>(first[1]);
        if (!(x >= 0.0 && y >= 0.0 && x < static_cast<double>(size[0]) && y < static_cast<double>(size[1]))) continue;
        double &height = plan[static_cast<int64_t>(x) * size[1] + static_cast<int64_t>(y)];
        if (sign * p[2] > height) height = sign * p[2];
    }
}
