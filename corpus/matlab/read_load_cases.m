function cases = read_load_cases(file, loads)
%READ_LOAD_CASES  The load cases and the forces they drive.
%
%   cases = read_load_cases(file, loads) reads a CSV file with a header line. LOADS is a cell array with the name of a column and
%   the number of the SFORCE it drives in each row. CASES has the fields
%     .label     names of the load cases (column `case`)
%     .sforce    numbers of the SFORCE statements
%     .load      one row per load case, one column per SFORCE

[header, rows] = csv_cells(file);
cases.label = rows(:, csv_column(header, 'case', file));
cases.sforce = [loads{:, 2}];
cases.load = zeros(size(rows, 1), size(loads, 1));
for k = 1:size(loads, 1)
    cases.load(:, k) = str2double(rows(:, csv_column(header, loads{k, 1}, file)));
end
