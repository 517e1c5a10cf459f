package vantage.spy;

import java.awt.BorderLayout;
import java.awt.Color;
import java.awt.Component;
import java.awt.Dimension;
import java.util.ArrayList;
import java.util.List;
import javax.swing.BorderFactory;
import javax.swing.BoxLayout;
import javax.swing.JComponent;
import javax.swing.JLabel;
import javax.swing.JPanel;
import javax.swing.JScrollPane;
import javax.swing.JTable;
import javax.swing.table.DefaultTableCellRenderer;
import javax.swing.table.TableColumn;

/** Tables one below the other; columns are as wide as what was in them so far. */
final class TablesPanel {
  private static final Color ALARM = new Color(190, 30, 30);
  private static final int MAX_COLUMN_WIDTH = 420; // px

  private final JPanel panel = new JPanel();
  private final List<Table> tables = new ArrayList<>();

  /** One table a height, px. */
  TablesPanel(int width, int... heights) {
    panel.setLayout(new BoxLayout(panel, BoxLayout.Y_AXIS));
    for (int height : heights) {
      Table table = new Table();
      tables.add(table);
      JPanel part = new JPanel(new BorderLayout());
      part.add(table.title, BorderLayout.NORTH);
      part.add(new JScrollPane(table.table), BorderLayout.CENTER);
      part.setPreferredSize(new Dimension(width, height));
      panel.add(part);
    }
  }

  JComponent component() {
    return panel;
  }

  void show(List<Rows> contents) {
    for (int i = 0; i < tables.size(); i++) {
      tables.get(i).show(contents.get(i));
    }
  }

  private static final class Table {
    private final JLabel title = new JLabel(" ");
    private final RowsModel model = new RowsModel();
    private final JTable table = new JTable(model);

    Table() {
      title.putClientProperty("html.disable", Boolean.TRUE);
      title.setBorder(BorderFactory.createEmptyBorder(4, 8, 4, 8));
      table.setAutoResizeMode(JTable.AUTO_RESIZE_OFF);
      table.setFillsViewportHeight(true);
      table.setDefaultRenderer(Object.class, new CellRenderer(model));
    }

    void show(Rows rows) {
      title.setText(rows.title());
      int selected = table.getSelectedRow();
      model.show(rows);
      if (selected >= 0 && selected < table.getRowCount()) {
        table.setRowSelectionInterval(selected, selected);
      }
      widen(rows);
    }

    private void widen(Rows rows) {
      for (int c = 0; c < table.getColumnCount(); c++) {
        int width = widthOf(rows.columns()[c]);
        for (Rows.Row row : rows.rows()) {
          width = Math.max(width, widthOf(row.cells()[c]));
        }
        TableColumn column = table.getColumnModel().getColumn(c);
        if (width > column.getPreferredWidth()) {
          column.setPreferredWidth(width);
        }
      }
    }

    private int widthOf(String text) {
      int width = table.getFontMetrics(table.getFont()).stringWidth(text) + 14;
      return Math.min(MAX_COLUMN_WIDTH, width);
    }
  }

  private static final class CellRenderer extends DefaultTableCellRenderer {
    private static final long serialVersionUID = 1;
    private final RowsModel model;

    CellRenderer(RowsModel model) {
      this.model = model;
      putClientProperty("html.disable", Boolean.TRUE);
    }

    @Override
    public Component getTableCellRendererComponent(
        JTable table, Object value, boolean selected, boolean focus, int row, int column) {
      super.getTableCellRendererComponent(table, value, selected, false, row, column);
      if (!selected) {
        setForeground(model.isAlarm(row) ? ALARM : table.getForeground());
      }
      return this;
    }
  }
}
