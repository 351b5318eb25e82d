function [parts, marks, points, labels] = read_marks(file, with_cases)
%READ_MARKS  Coordinates of marks.
%
%   [parts, marks, points] = read_marks(file, 0) reads the CSV file of the first session, in the axes of each part: part names
%   (cell array), mark numbers and coordinates (n x 3).
%
%   [parts, marks, points, labels] = read_marks(file, 1) reads the file measured on the rig, which has a column `case` besides.

[header, rows] = csv_cells(file);
parts = rows(:, csv_column(header, 'part', file));
marks = str2double(rows(:, csv_column(header, 'mark', file)));
points = zeros(size(rows, 1), 3);
axes_ = 'xyz';
for k = 1:3
    points(:, k) = str2double(rows(:, csv_column(header, axes_(k), file)));
end
labels = {};
if with_cases
    labels = rows(:, csv_column(header, 'case', file));
end
