// The closest places of two sampled surfaces.
#include <numeric>

#include "plane.hpp"
#include "tree.hpp"

using namespace topple;

namespace {

// Rows, rising, of the `most` points (count, 3) nearest to those of a tree, likely ones asked first.
std::vector<int64_t> nearest_rows(const double *points, const double *likely, int64_t count, const Tree &to,
                                  int64_t most) {
    std::vector<int64_t> rows(count);
    std::iota(rows.begin(), rows.end(), 0);
    if (count <= most) return rows;
    std::nth_element(rows.begin(), rows.begin() + most, rows.end(),
                     [likely](int64_t a, int64_t b) { return likely[a] < likely[b]; });
    std::vector<Found> heap, best(1);  // the furthest of the nearest bounds how far the others may be
    for (int64_t i = 0; i < count; ++i) {
        to.nearest(points + 3 * rows[i], best, i < most ? FAR : heap.front().square);
        if (best[0].row < 0) continue;
        heap.push_back({best[0].square, static_cast<int32_t>(rows[i])});
        std::push_heap(heap.begin(), heap.end());
        if (i < most) continue;
        std::pop_heap(heap.begin(), heap.end());
        heap.pop_back();
    }
    rows.resize(most);
    std::transform(heap.begin(), heap.end(), rows.begin(), [](const Found &one) { return one.row; });
    std::sort(rows.begin(), rows.end());
    return rows;
}

inline double length(const double *a, const double *b) {
    const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return std::sqrt(x * x + y * y + z * z);
}

// How far a place is from the surface that its nearest samples show, as far as these reach.
double to_surface(const double *place, const double *samples, const std::vector<Found> &near,
                  std::vector<double> &patch) {
    const double away = std::sqrt(near[0].square);
    const size_t size = near.size();
    if (size < 3) return away;
    for (size_t j = 0; j < size; ++j) std::copy_n(samples + 3 * near[j].row, 3, &patch[3 * j]);
    double middle[3], normal[3], squares[3], height = 0.0, along = 0.0, reach = 0.0;
    plane_of(patch.data(), static_cast<int64_t>(size), middle, normal, squares);
    for (int k = 0; k < 3; ++k) {
        height += (place[k] - middle[k]) * normal[k];
        along += (place[k] - patch[k]) * normal[k];
    }
    const size_t few = std::min<size_t>(size, 4);
    for (size_t j = 1; j < few; ++j) reach += length(&patch[3 * j], patch.data());
    reach *= 0.5 / static_cast<double>(few - 1);  // samples reach half their spacing beyond the last one
    const double beside = std::max(std::sqrt(std::max(away * away - along * along, 0.0)) - reach, 0.0);
    return std::min(away, std::sqrt(height * height + beside * beside));
}

}  // namespace

// Of the points of two surfaces, `counts` of them (count, 3), the `most` of each that are nearest to the other:
// how far they are from the surface that the `patch` nearest samples show, and from the nearest of these, (2, most)
// each. `likely` is less where a point is likely to be near.
extern "C" void closest_places(const double *first, const double *second, const double *likely_first,
                               const double *likely_second, const int64_t *counts, int64_t most, int64_t patch,
                               double *distances, double *samples) {
    const double *points[2] = {first, second}, *likely[2] = {likely_first, likely_second};
    const Grown grown[2] = {{first, counts[0]}, {second, counts[1]}};
    for (int s = 0; s < 2; ++s) {
        const Tree &other = grown[1 - s].tree;
        const std::vector<int64_t> rows = nearest_rows(points[s], likely[s], counts[s], other, most);
        std::vector<Found> near(std::min(patch, counts[1 - s]));
        std::vector<double> held(3 * near.size());
        for (size_t i = 0; i < rows.size(); ++i) {
            const double *place = points[s] + 3 * rows[i];
            other.nearest(place, near, FAR);
            distances[s * most + i] = to_surface(place, points[1 - s], near, held);
            samples[s * most + i] = std::sqrt(near[0].square);
        }
    }
}
