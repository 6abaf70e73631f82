// A plugin for tests that looks at MeshLab 2020's window from inside: it loads a cloud, finds the filter in the menus,
// runs it with its default parameters through the dialog a user would see, and saves pictures. MeshLab loads it as any
// plugin.
//   PROBE_FILTER  name of the filter to run   PROBE_FOLDER  where report.txt and pictures go
//   PROBE_MENUS   names of filters to look for in the menus, separated by '|'
// The cloud is given to MeshLab on its command line.
#include <host.h>

#include <QApplication>
#include <QDialog>
#include <QFile>
#include <QMainWindow>
#include <QMenuBar>
#include <QPushButton>
#include <QScreen>
#include <QTextStream>
#include <QTimer>

class GuiProbe : public QObject, public MeshFilterInterface
{
    Q_OBJECT
    MESHLAB_PLUGIN_IID_EXPORTER(MESH_FILTER_INTERFACE_IID)
    Q_INTERFACES(MeshFilterInterface)

public:
    GuiProbe()
    {
        if (qEnvironmentVariableIsSet("PROBE_FILTER"))
            QTimer::singleShot(8000, this, &GuiProbe::open_dialog);
    }

    QString filterName(FilterIDType) const override { return {}; }
    QString filterInfo(FilterIDType) const override { return {}; }
    FILTER_ARITY filterArity(QAction*) const override { return NONE; }
    bool applyFilter(QAction*, MeshDocument&, const RichParameterList&, vcg::CallBackPos*) override { return false; }

private:
    QString folder() const { return qEnvironmentVariable("PROBE_FOLDER"); }

    void report(const QString& line) const
    {
        QFile file(folder() + "/report.txt");
        if (file.open(QIODevice::Append))
            QTextStream(&file) << line << "\n";
    }

    void save_picture(const QString& name) const
    {
        QGuiApplication::primaryScreen()->grabWindow(0).save(folder() + "/" + name);
    }

    static QMainWindow* window()
    {
        for (QWidget* widget : QApplication::topLevelWidgets())
            if (auto* main = qobject_cast<QMainWindow*>(widget))
                if (main->menuBar() && main->menuBar()->actions().size() > 3)
                    return main;
        return nullptr;
    }

    /// Reports every place of the filter in the menus.
    QAction* find(const QString& name, const QList<QAction*>& actions, const QString& path) const
    {
        QAction* found = nullptr;
        for (QAction* action : actions)
        {
            const QString here = path + "/" + QString(action->text()).remove('&');
            if (action->menu())
            {
                QAction* inside = find(name, action->menu()->actions(), here);
                found = inside ? inside : found;
            }
            else if (action->text() == name)
            {
                report("menu " + here + (action->isEnabled() ? "" : " (disabled)"));
                found = action;
            }
        }
        return found;
    }

    void open_dialog()
    {
        QMainWindow* main = window();
        if (main)
            for (const QString& name : qEnvironmentVariable("PROBE_MENUS").split('|'))
                find(name, main->menuBar()->actions(), "");
        QAction* action = main ? find(qEnvironmentVariable("PROBE_FILTER"), main->menuBar()->actions(), "") : nullptr;
        if (!action)
        {
            report(main ? "no such filter" : "no window");
            return quit();
        }
        main->setGeometry(0, 0, 1280, 1024);
        QTimer::singleShot(3000, this, &GuiProbe::apply);
        action->trigger();
    }

    void apply()
    {
        save_picture("dialog.png");
        for (QWidget* widget : QApplication::allWidgets())
            if (auto* button = qobject_cast<QPushButton*>(widget))
                if (button->isVisible() && QString(button->text()).remove('&') == "Apply")
                {
                    report("apply");
                    QTimer::singleShot(6000, this, &GuiProbe::look); // after the filter has run, on this thread
                    button->click();
                    return;
                }
        report("no Apply button");
        quit();
    }

    void look()
    {
        if (QDialog* box = qobject_cast<QDialog*>(QApplication::activeModalWidget()))
            report("message " + box->windowTitle());
        for (QWidget* widget : QApplication::allWidgets()) // the filter's dialog hides the surface
            if (auto* button = qobject_cast<QPushButton*>(widget))
                if (button->isVisible() && QString(button->text()).remove('&') == "Close")
                    button->click();
        QTimer::singleShot(2000, this, &GuiProbe::finish);
    }

    void finish()
    {
        save_picture("result.png");
        report("done");
        quit();
    }

    void quit() const { std::_Exit(0); } // past MeshLab's questions about unsaved layers
};

#include "gui_probe.moc"
