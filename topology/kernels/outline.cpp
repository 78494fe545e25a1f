// The corners of the convex outline of points in a plane.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

namespace {

constexpr int WAYS = 8;  // directions whose furthest points leave few others outside of their outline
constexpr double FLAT = 1e-13;  // area against the squared extent: three points in a line

struct Place {
    double x, y;
    int64_t row;
};

// Twice the area of a triangle, positive where it turns to the left.
inline double turn(const Place &a, const Place &b, const Place &c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Corners of sorted places, one half of the outline after the other, to the left.
std::vector<Place> outline(const std::vector<Place> &places, double least) {
    std::vector<Place> found;
    for (int half = 0; half < 2; ++half) {
        const size_t begin = found.size();
        for (size_t i = 0; i < places.size(); ++i) {
            const Place &next = half ? places[places.size() - 1 - i] : places[i];
            while (found.size() >= begin + 2 && turn(found[found.size() - 2], found.back(), next) <= least)
                found.pop_back();
            found.push_back(next);
        }
        found.pop_back();  // where the other half begins
    }
    return found;
}

}  // namespace

// Rows of the corners of the outline of points (count, 2), count > 0, to the left from the first along x and y:
// how many, 0 where the points lie in a line.
extern "C" int64_t outline_corners(const double *points, int64_t count, int64_t *rows) {
    const double way[WAYS][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    double reach[WAYS];
    int64_t furthest[WAYS] = {};
    std::fill_n(reach, WAYS, -std::numeric_limits<double>::infinity());
    for (int64_t i = 0; i < count; ++i)
        for (int w = 0; w < WAYS; ++w) {
            const double along = points[2 * i] * way[w][0] + points[2 * i + 1] * way[w][1];
            if (along > reach[w]) reach[w] = along, furthest[w] = i;
        }
    const double extent = std::max(reach[0] + reach[4], reach[2] + reach[6]), least = FLAT * extent * extent;
    Place ring[WAYS + 1];
    for (int w = 0; w <= WAYS; ++w) {
        const int64_t row = furthest[w % WAYS];
        ring[w] = {points[2 * row], points[2 * row + 1], row};
    }
    std::vector<Place> left;
    for (int64_t i = 0; i < count; ++i) {
        const Place place{points[2 * i], points[2 * i + 1], i};
        bool inside = true;  // or on a side, where none but its ends are corners
        for (int w = 0; w < WAYS && inside; ++w)
            inside = ring[w].row != i && (ring[w].row == ring[w + 1].row || turn(ring[w], ring[w + 1], place) > -least);
        if (!inside) left.push_back(place);
    }
    std::sort(left.begin(), left.end(), [](const Place &a, const Place &b) {
        return a.x < b.x || (a.x == b.x && (a.y < b.y || (a.y == b.y && a.row < b.row)));
    });
    const std::vector<Place> corners = outline(left, least);
    if (corners.size() < 3) return 0;
    for (size_t i = 0; i < corners.size(); ++i) rows[i] = corners[i].row;
    return static_cast<int64_t>(corners.size());
}
