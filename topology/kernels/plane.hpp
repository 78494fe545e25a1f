// The plane through a patch of points, by least squares: eigenvectors of a symmetric matrix of three (Jacobi).
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace topple {

constexpr int SWEEPS = 30;  // at most: five are usual

// Diagonalise a symmetric matrix by turning it; the columns of `axes` become its eigenvectors.
inline void diagonalise(double matrix[3][3], double axes[3][3]) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) axes[i][j] = i == j;
    for (int sweep = 0; sweep < SWEEPS; ++sweep) {
        if (matrix[0][1] == 0.0 && matrix[0][2] == 0.0 && matrix[1][2] == 0.0) return;
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                const double off = matrix[p][q], least = std::min(std::fabs(matrix[p][p]), std::fabs(matrix[q][q]));
                if (sweep > 3 && std::fabs(off) <= 1e-18 * least) matrix[p][q] = matrix[q][p] = 0.0;
                if (matrix[p][q] == 0.0) continue;
                const double angle = (matrix[q][q] - matrix[p][p]) / (2.0 * off);
                const double t = (angle >= 0.0 ? 1.0 : -1.0) / (std::fabs(angle) + std::sqrt(angle * angle + 1.0));
                const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double x = matrix[k][p], y = matrix[k][q];
                    matrix[k][p] = c * x - s * y;
                    matrix[k][q] = s * x + c * y;
                }
                for (int k = 0; k < 3; ++k) {
                    const double x = matrix[p][k], y = matrix[q][k];
                    matrix[p][k] = c * x - s * y;
                    matrix[q][k] = s * x + c * y;
                }
                matrix[p][q] = matrix[q][p] = 0.0;
                for (int k = 0; k < 3; ++k) {
                    const double x = axes[k][p], y = axes[k][q];
                    axes[k][p] = c * x - s * y;
                    axes[k][q] = s * x + c * y;
                }
            }
    }
}

// Of a patch (size, 3), size > 0: its (3,) middle, the (3,) unit normal of its plane, of either sign, and (3,) sums
// of squared distances from the middle along it and along the patch, rising.
inline void plane_of(const double *patch, int64_t size, double *middle, double *normal, double *squares) {
    std::fill_n(middle, 3, 0.0);
    for (int64_t i = 0; i < size; ++i)
        for (int k = 0; k < 3; ++k) middle[k] += patch[3 * i + k];
    for (int k = 0; k < 3; ++k) middle[k] /= static_cast<double>(size);
    double matrix[3][3] = {}, axes[3][3];
    for (int64_t i = 0; i < size; ++i) {
        const double x = patch[3 * i] - middle[0], y = patch[3 * i + 1] - middle[1];
        const double z = patch[3 * i + 2] - middle[2];
        matrix[0][0] += x * x;
        matrix[0][1] += x * y;
        matrix[0][2] += x * z;
        matrix[1][1] += y * y;
        matrix[1][2] += y * z;
        matrix[2][2] += z * z;
    }
    for (int p = 1; p < 3; ++p)
        for (int q = 0; q < p; ++q) matrix[p][q] = matrix[q][p];
    diagonalise(matrix, axes);
    int order[3] = {0, 1, 2};
    std::sort(order, order + 3, [&](int a, int b) { return matrix[a][a] < matrix[b][b]; });
    for (int k = 0; k < 3; ++k) {
        squares[k] = std::max(matrix[order[k]][order[k]], 0.0);
        normal[k] = axes[k][order[0]];
    }
}

}  // namespace topple
