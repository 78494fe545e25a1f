// Points sorted into the cubic cells of a grid, which may lie along axes of its own; means by cell.
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>

namespace {

constexpr int DIGIT = 11;  // bits that a round of the radix sort tells apart
constexpr double MOST = 9e18;  // a cell's number along an axis: below 2^63

// Where a point lies along the rows of `turn` from the first point; as it is where there is no turn.
inline void turned(const double *points, int64_t i, const double *turn, double *place) {
    const double *p = points + 3 * i;
    if (turn == nullptr) {
        std::copy_n(p, 3, place);
        return;
    }
    const double x = p[0] - points[0], y = p[1] - points[1], z = p[2] - points[2];
    for (int k = 0; k < 3; ++k) place[k] = x * turn[3 * k] + y * turn[3 * k + 1] + z * turn[3 * k + 2];
}

// See `cells_sort`; the narrower the keys the sooner.
template <class Key>
int64_t sort(const double *points, int64_t count, const double *turn, const double *first, const int64_t *along,
             double edge, int64_t *order, int64_t *starts) {
    struct Entry {
        Key key, row;
    };
    const std::unique_ptr<Entry[]> held(new Entry[2 * count]);
    Entry *entries = held.get(), *sorted = entries + count;
    const double scale = 1.0 / edge;
    double place[3];
    Key most = 0;
    for (int64_t i = 0; i < count; ++i) {
        turned(points, i, turn, place);
        Key key = 0;
        for (int k = 0; k < 3; ++k) {
            const double cell = std::min(std::max((place[k] - first[k]) * scale, 0.0), MOST);
            key = key * static_cast<Key>(along[k]) + static_cast<Key>(static_cast<int64_t>(cell));
        }
        entries[i] = {key, static_cast<Key>(i)};
        most = std::max(most, key);
    }
    for (unsigned shift = 0; shift < 8 * sizeof(Key) && most >> shift != 0; shift += DIGIT) {  // stable, by digits
        std::array<int64_t, (1 << DIGIT) + 1> begin = {};
        const Key mask = (1 << DIGIT) - 1;
        for (int64_t i = 0; i < count; ++i) ++begin[(entries[i].key >> shift & mask) + 1];
        for (int64_t d = 0; d < 1 << DIGIT; ++d) begin[d + 1] += begin[d];
        for (int64_t i = 0; i < count; ++i) sorted[begin[entries[i].key >> shift & mask]++] = entries[i];
        std::swap(entries, sorted);
    }
    int64_t cells = 0;
    for (int64_t i = 0; i < count; ++i) {
        if (i == 0 || entries[i].key != entries[i - 1].key) starts[cells++] = i;
        order[i] = static_cast<int64_t>(entries[i].row);
    }
    starts[cells] = count;
    return cells;
}

}  // namespace

extern "C" {

// Least and greatest coordinates of points (count, 3), turned, count > 0: (2, 3) bounds.
void cells_bounds(const double *points, int64_t count, const double *turn, double *bounds) {
    std::fill_n(bounds, 3, std::numeric_limits<double>::infinity());
    std::fill_n(bounds + 3, 3, -std::numeric_limits<double>::infinity());
    double place[3];
    for (int64_t i = 0; i < count; ++i) {
        turned(points, i, turn, place);
        for (int k = 0; k < 3; ++k) {
            bounds[k] = std::min(bounds[k], place[k]);
            bounds[3 + k] = std::max(bounds[3 + k], place[k]);
        }
    }
}

// Rows of points (count, 3), turned, by the cell they lie in, rising within each, and where each cell starts,
// the last one's end included: how many cells there are. The grid begins at `first`, at or before all points,
// and has so many cells along each axis; they follow each other along the last axis first.
int64_t cells_sort(const double *points, int64_t count, const double *turn, const double *first,
                   const int64_t *along, double edge, int64_t *order, int64_t *starts) {
    const double cells = static_cast<double>(along[0]) * static_cast<double>(along[1]) * static_cast<double>(along[2]);
    return cells < 4e9 ? sort<uint32_t>(points, count, turn, first, along, edge, order, starts)
                       : sort<uint64_t>(points, count, turn, first, along, edge, order, starts);
}

// Which points (count, 3) have a square of at most a limit from a place.
void cells_within(const double *points, int64_t count, const double *place, double limit, uint8_t *within) {
    for (int64_t i = 0; i < count; ++i) {
        const double x = points[3 * i] - place[0], y = points[3 * i + 1] - place[1], z = points[3 * i + 2] - place[2];
        within[i] = x * x + y * y + z * z <= limit;
    }
}

// The (cells, 3) means of the points of each cell, summed in the order of their rows.
void cells_means(const double *points, const int64_t *order, const int64_t *starts, int64_t cells, double *means) {
    for (int64_t c = 0; c < cells; ++c) {
        double sum[3] = {0.0, 0.0, 0.0};
        for (int64_t i = starts[c]; i < starts[c + 1]; ++i)
            for (int k = 0; k < 3; ++k) sum[k] += points[3 * order[i] + k];
        for (int k = 0; k < 3; ++k) means[3 * c + k] = sum[k] / static_cast<double>(starts[c + 1] - starts[c]);
    }
}
}
