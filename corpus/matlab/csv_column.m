function k = csv_column(header, name, file)
%CSV_COLUMN  The number of the column with this name.

k = find(strcmpi(header, name));
if length(k) ~= 1
    error('csv_column: no column "%s" in %s', name, file);
end
