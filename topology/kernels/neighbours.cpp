// What is asked of a tree: the nearest neighbours of places, and all within a radius of them. The arrays are the
// caller's, so nothing is kept or freed.
#include "tree.hpp"

using namespace topple;

extern "C" {

// Bytes of the leaves and of the groups of a tree over so many points.
void tree_sizes(int64_t count, int64_t *leaves, int64_t *groups) {
    const Shape shape(count);
    *leaves = shape.boxes[0] * static_cast<int64_t>(sizeof(Leaf));
    *groups = shape.groups() * static_cast<int64_t>(sizeof(Group));
}

// Fill the leaves and groups of a tree over points (count, 3), count > 0.
void tree_build(const double *points, int64_t count, Leaf *leaves, Group *groups) {
    grow(points, count, leaves, groups);
}

// The `most` nearest points of places (asked, 3): (asked, most) distances and rows, rising; infinite and
// `count` beyond what there is below a bound.
void tree_nearest(const Leaf *leaves, const Group *groups, int64_t count, const double *points,
                  const double *places, int64_t asked, int64_t most, double bound, double *distances,
                  int64_t *rows) {
    const Tree tree(leaves, groups, count);
    std::vector<Found> best(most);
    for (int64_t q = 0; q < asked; ++q) {
        const double *place = places + 3 * q;
        const double limit = bound * bound;
        // The neighbours of the place before are neighbours, if not the nearest: they bound how far these are.
        double known = -1.0;
        for (int64_t j = 0; j < most; ++j) {
            if (q == 0 || rows[(q - 1) * most + j] >= count) {
                known = FAR;
                break;
            }
            const double *point = points + 3 * rows[(q - 1) * most + j];
            const double x = point[0] - place[0], y = point[1] - place[1], z = point[2] - place[2];
            known = std::max(known, x * x + y * y + z * z);
        }
        const bool nearer = known < limit;
        tree.nearest(place, best, nearer ? known : limit, nearer ? std::numeric_limits<int32_t>::max() : -1);
        write(best, count, distances + q * most, rows + q * most);
    }
}

// Rows of the points within a radius of each of some places, one place after the other and rising for each:
// how many each place has, and how many all have; no more than `room` rows are written.
int64_t tree_within(const Leaf *leaves, const Group *groups, int64_t count, const double *places, int64_t asked,
                    double radius, int64_t *counts, int64_t *rows, int64_t room) {
    const Tree tree(leaves, groups, count);
    std::vector<Found> near(count + LEAF);
    std::vector<int64_t> boxes;
    int64_t total = 0;
    for (int64_t q = 0; q < asked; ++q) {
        const double *place = places + 3 * q;
        tree.leaves_within(place, place, radius * radius, boxes);
        Found *end = near.data();
        for (const int64_t box : boxes) end = points_within(leaves[box], place, radius * radius, end);
        std::sort(near.data(), end, [](const Found &a, const Found &b) { return a.row < b.row; });
        counts[q] = end - near.data();
        if (total + counts[q] <= room)
            std::transform(near.data(), end, rows + total, [](const Found &one) { return one.row; });
        total += counts[q];
    }
    return total;
}

// Of each point: the sum of the weights of all within a radius, itself among them, and the `most` nearest points
// as `tree_nearest` has them: mostly they are within the radius, too. The points of a leaf have the same leaves
// around them.
void tree_around(const Leaf *leaves, const Group *groups, int64_t count, const double *points, double radius,
                 const double *weights, int64_t most, double *sums, double *distances, int64_t *rows) {
    const Tree tree(leaves, groups, count);
    const double limit = radius * radius;
    std::vector<Found> near(count + LEAF), best(most);
    std::vector<double> at[3], squares(count + LEAF);  // of the points around a leaf
    std::vector<int32_t> which(count + LEAF);
    for (auto &axis : at) axis.resize(count + LEAF);
    std::vector<int64_t> around;
    for (int64_t home = 0; home * LEAF < count; ++home) {
        double low[3], high[3];
        for (int k = 0; k < 3; ++k) {
            low[k] = groups[home / FAN].lower[k][home % FAN];
            high[k] = groups[home / FAN].upper[k][home % FAN];
        }
        tree.leaves_within(low, high, limit, around);
        std::swap(around[0], *std::find(around.begin(), around.end(), home));  // the nearest lie in it, mostly
        int64_t held = 0;
        for (const int64_t box : around)
            for (int s = 0; s < LEAF; ++s) {
                double square = 0.0;
                for (int k = 0; k < 3; ++k) {
                    const double place = at[k][held] = leaves[box].at[k][s];
                    const double beside = std::max(std::max(low[k] - place, place - high[k]), 0.0);
                    square += beside * beside;
                }
                which[held] = leaves[box].row[s];
                held += square <= limit;  // what stands behind the last point is infinitely far
            }
        for (int p = 0; p < LEAF && leaves[home].row[p] >= 0; ++p) {
            const int64_t q = leaves[home].row[p];
            const double *place = points + 3 * q;
            Found *end = near.data();
            for (int64_t i = 0; i < held; ++i) {
                const double x = at[0][i] - place[0], y = at[1][i] - place[1], z = at[2][i] - place[2];
                squares[i] = x * x + y * y + z * z;
            }
            for (int64_t i = 0; i < held; ++i) {
                *end = {squares[i], which[i]};
                end += squares[i] <= limit;
            }
            double sum = 0.0;
            std::fill(best.begin(), best.end(), Found{FAR, -1});
            for (const Found *one = near.data(); one < end; ++one) {
                sum += weights[one->row];
                insert(*one, best);
            }
            sums[q] = sum;
            if (end - near.data() < most) tree.nearest(place, best, FAR);
            write(best, count, distances + q * most, rows + q * most);
        }
    }
}
}
