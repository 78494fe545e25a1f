// The circle or sphere nearest to points, by least squares of the distances (Gauss-Newton).
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace {

constexpr int BLOCK = 256;  // points whose rays are held at once: 8 kB
constexpr int WIDE = 4;     // unknowns: a centre and a radius
constexpr double LEAST = 1e-9;  // of a ray [m]: at the centre it has no direction
constexpr double FLAT = 1e-13;  // of squares, against the largest: points in a plane

using Lanes = double __attribute__((vector_size(32)));  // summed apart, so that all machines round alike

struct Sums {  // of products of the columns of a system of equations, and of those with its right side
    double of[WIDE][WIDE] = {};
    double right[WIDE] = {};
};

double dot(const double *a, const double *b) {  // of two blocks
    Lanes sum = {};
    for (int i = 0; i < BLOCK; i += 4) {
        const Lanes x = {a[i], a[i + 1], a[i + 2], a[i + 3]}, y = {b[i], b[i + 1], b[i + 2], b[i + 3]};
        sum += x * y;
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

// Solve for `size` unknowns in place, by elimination; whether there is one solution.
bool solve(Sums &system, int size, double *solution, double least) {
    for (int c = 0; c < size; ++c) {
        int pivot = c;
        for (int r = c + 1; r < size; ++r)
            if (std::fabs(system.of[r][c]) > std::fabs(system.of[pivot][c])) pivot = r;
        if (!(std::fabs(system.of[pivot][c]) > least)) return false;
        std::swap(system.of[c], system.of[pivot]);
        std::swap(system.right[c], system.right[pivot]);
        for (int r = c + 1; r < size; ++r) {
            const double share = system.of[r][c] / system.of[c][c];
            for (int k = c; k < size; ++k) system.of[r][k] -= share * system.of[c][k];
            system.right[r] -= share * system.right[c];
        }
    }
    for (int c = size - 1; c >= 0; --c) {
        solution[c] = system.right[c];
        for (int k = c + 1; k < size; ++k) solution[c] -= system.of[c][k] * solution[k];
        solution[c] /= system.of[c][c];
    }
    return true;
}

class Cloud {  // points about their middle, an axis at a time, in whole blocks
  public:
    Cloud(const double *points, int64_t count, int axes)
        : axes(axes), count(count), blocks((count + BLOCK - 1) / BLOCK), columns(axes * blocks * BLOCK, 0.0) {
        for (int64_t i = 0; i < count; ++i)
            for (int k = 0; k < axes; ++k) middle[k] += points[axes * i + k];
        for (int k = 0; k < axes; ++k) middle[k] /= static_cast<double>(count);
        for (int64_t i = 0; i < count; ++i)
            for (int k = 0; k < axes; ++k) column(k)[i] = points[axes * i + k] - middle[k];
    }

    // By the squared distances, |p|^2 = 2 c.p + r^2 - |c|^2, which is linear: about the middle, c alone.
    bool first(double *centre, double &radius) {
        Sums system;
        double squares[BLOCK], total = 0.0;
        for (int64_t b = 0; b < blocks; ++b) {
            std::fill_n(squares, BLOCK, 0.0);
            for (int k = 0; k < axes; ++k)
                for (int i = 0; i < BLOCK; ++i) squares[i] += block(k, b)[i] * block(k, b)[i];
            for (int i = 0; i < BLOCK; ++i) total += squares[i];
            for (int j = 0; j < axes; ++j) {
                system.right[j] += 0.5 * dot(block(j, b), squares);
                for (int k = 0; k < axes; ++k) system.of[j][k] += dot(block(j, b), block(k, b));
            }
        }
        double largest = 0.0;
        for (int k = 0; k < axes; ++k) largest = std::max(largest, system.of[k][k]);
        if (!solve(system, axes, centre, FLAT * largest)) return false;
        radius = total / static_cast<double>(count);
        for (int k = 0; k < axes; ++k) radius += centre[k] * centre[k];
        radius = std::sqrt(std::max(radius, 1e-12));
        return true;
    }

    // The step of the distances' least squares from a centre and radius.
    bool step(const double *centre, double radius, double *change) {
        Sums system;
        double rays[WIDE][BLOCK], off[BLOCK], near[BLOCK];
        for (int64_t b = 0; b < blocks; ++b) {
            const int held = static_cast<int>(std::min<int64_t>(BLOCK, count - b * BLOCK));
            std::fill_n(off, BLOCK, 0.0);
            for (int k = 0; k < axes; ++k)
                for (int i = 0; i < BLOCK; ++i) {
                    rays[k][i] = block(k, b)[i] - centre[k];
                    off[i] += rays[k][i] * rays[k][i];
                }
            for (int i = 0; i < BLOCK; ++i) {
                const double far = std::max(std::sqrt(off[i]), LEAST);
                near[i] = 1.0 / far;
                off[i] = far - radius;
            }
            for (int k = 0; k < axes; ++k)
                for (int i = 0; i < BLOCK; ++i) rays[k][i] *= near[i];
            std::fill_n(rays[axes], BLOCK, 1.0);
            for (int k = 0; k <= axes; ++k) std::fill(rays[k] + held, rays[k] + BLOCK, 0.0);
            for (int j = 0; j <= axes; ++j) {
                system.right[j] += dot(rays[j], off);
                for (int k = j; k <= axes; ++k) system.of[j][k] += dot(rays[j], rays[k]);
            }
        }
        for (int j = 0; j <= axes; ++j)
            for (int k = 0; k < j; ++k) system.of[j][k] = system.of[k][j];
        return solve(system, axes + 1, change, 0.0);
    }

    double middle[3] = {0.0, 0.0, 0.0};

  private:
    const int axes;
    const int64_t count, blocks;
    std::vector<double> columns;

    double *column(int axis) { return columns.data() + axis * blocks * BLOCK; }
    const double *block(int axis, int64_t number) { return column(axis) + number * BLOCK; }
};

}  // namespace

// Fit a circle (axes = 2) or a sphere (3) to points (count, axes), count > 0: its centre, then its radius.
// At most so many rounds; no more once a step is shorter than `still`. Gives 0 where none fits: for points on
// a line or in a plane, and for radii beyond the largest.
extern "C" int64_t sphere_nearest(const double *points, int64_t count, int64_t axes, int64_t rounds, double still,
                                  double largest, double *fit) {
    const int size = static_cast<int>(axes);
    Cloud cloud(points, count, size);
    double centre[3], radius = 0.0, change[WIDE];
    if (!cloud.first(centre, radius)) return 0;
    for (int64_t round = 0; round < rounds; ++round) {
        if (!cloud.step(centre, radius, change)) return 0;
        double most = 0.0;
        for (int k = 0; k <= size; ++k) most = std::max(most, std::fabs(change[k]));
        for (int k = 0; k < size; ++k) centre[k] += change[k];
        radius += change[size];
        if (!std::isfinite(radius) || std::fabs(radius) > largest) return 0;
        if (most < still) break;
    }
    for (int k = 0; k < size; ++k) fit[k] = centre[k] + cloud.middle[k];
    fit[size] = radius;
    return radius > 0.0;
}
